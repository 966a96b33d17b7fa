// SPDX-License-Identifier: Apache-2.0
// Property: any two uses of random numbers in a picture are independent: what one draws tells
// nothing of what the other does.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr int kSide = 64, kCells = kSide * kSide;
constexpr std::uint32_t kDraws = 1u << 14;  // 4 to a cell
constexpr std::uint32_t kKeys = 16;         // as many pixels

// The numbers that a use draws, one for each index; the kernels draw the same (core_surfaces_test).
std::vector<Vec2f> draws(std::uint32_t key, std::uint32_t number) {
  std::vector<Vec2f> points(kDraws);
  for (std::uint32_t i = 0; i < kDraws; ++i) points[i] = shuffled_2d(hash_combine(key, number), i);
  return points;
}

double chi_square(const std::vector<Vec2f>& a, float Vec2f::*of_a, const std::vector<Vec2f>& b,
                  float Vec2f::*of_b) {
  std::array<int, kCells> count{};
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const int x = static_cast<int>(a[i].*of_a * kSide), y = static_cast<int>(b[i].*of_b * kSide);
    ++count[static_cast<std::size_t>(y * kSide + x)];
  }
  constexpr double kMean = static_cast<double>(kDraws) / kCells;
  double sum = 0;
  for (const int n : count) sum += (n - kMean) * (n - kMean) / kMean;
  return sum;
}

// Chi-square of two uses that are independent has a mean of at most kCells - 1: less where numbers
// are stratified. How much it varies depends on how orders are shuffled, so the deviation is
// measured, too: the mean is above that by six of its own deviations once in 10^9 times.
class Independence {
 public:
  void add(const std::vector<Vec2f>& a, const std::vector<Vec2f>& b) {
    for (float Vec2f::*of_a : {&Vec2f::x, &Vec2f::y}) {
      for (float Vec2f::*of_b : {&Vec2f::x, &Vec2f::y}) {
        const double value = chi_square(a, of_a, b, of_b);
        sum_ += value;
        sum_of_squares_ += value * value;
        ++count_;
      }
    }
  }
  double excess() const { return mean() - (kCells - 1); }
  double allowed() const {
    const double variance = sum_of_squares_ / count_ - mean() * mean();
    return 6 * std::sqrt(variance / count_);
  }
  void expect() const {
    EXPECT_LE(excess(), allowed());
    EXPECT_LE(excess(), 0.1 * kCells) << "or what is measured varies too much to tell";
  }

 private:
  double mean() const { return sum_ / count_; }
  double sum_ = 0, sum_of_squares_ = 0;
  int count_ = 0;
};

// The first three and the last dimension of each use.
template <std::size_t kCount>
std::vector<std::uint32_t> numbers_of(const DimensionRange (&ranges)[kCount]) {
  std::vector<std::uint32_t> numbers;
  for (const DimensionRange& range : ranges) {
    for (const std::uint32_t n : {0u, 1u, 2u, range.count - 1}) {
      const std::uint32_t number = dimension(range.first, n);
      if (n < range.count && (numbers.empty() || numbers.back() < number))
        numbers.push_back(number);
    }
  }
  return numbers;
}

// key_of(i): the key of pixel i.
template <std::size_t kCount, class KeyOf>
void expect_every_pair_independent(const DimensionRange (&ranges)[kCount], const KeyOf& key_of) {
  const std::vector<std::uint32_t> numbers = numbers_of(ranges);
  std::map<std::pair<std::uint32_t, std::uint32_t>, Independence> pairs;
  for (std::uint32_t pixel = 0; pixel < kKeys; ++pixel) {
    std::vector<std::vector<Vec2f>> all;
    for (const std::uint32_t n : numbers) all.push_back(draws(key_of(pixel), n));
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) pairs[{numbers[k], numbers[i]}].add(all[k], all[i]);
    }
  }
  for (const auto& [pair, independence] : pairs) {
    SCOPED_TRACE("dimensions " + std::to_string(pair.first) + ", " + std::to_string(pair.second));
    independence.expect();
  }
}

std::uint32_t surface_key(std::uint32_t pixel) {
  return pixel_key(3, static_cast<int>(pixel), 345, dimension(Dimension::kSurface));
}

TEST(Dimensions, EveryPairOfUsesOfASurfaceIsIndependent) {
  expect_every_pair_independent(kSurfaceDimensions, surface_key);
}

TEST(Dimensions, EveryPairOfUsesOfALightSubpathIsIndependent) {
  expect_every_pair_independent(kLightPathDimensions, mix_bits);
}

// A place on the lens is a point of the sequence in the sequence's own order.
TEST(Dimensions, TheLensIsIndependentOfEveryUseOfTheSurface) {
  for (const std::uint32_t n : numbers_of(kSurfaceDimensions)) {
    SCOPED_TRACE("dimension " + std::to_string(n));
    Independence independence;
    for (std::uint32_t pixel = 0; pixel < kKeys; ++pixel) {
      const std::uint32_t lens_key =
          pixel_key(3, static_cast<int>(pixel), 345, dimension(Dimension::kLens));
      std::vector<Vec2f> lens(kDraws);
      for (std::uint32_t i = 0; i < kDraws; ++i) lens[i] = sample_2d(lens_key, i);
      independence.add(lens, draws(surface_key(pixel), n));
    }
    independence.expect();
  }
}

TEST(Dimensions, TheSameUseOfTwoSurfacesOfAPathIsIndependent) {
  for (const std::uint32_t n : numbers_of(kSurfaceDimensions)) {
    SCOPED_TRACE("dimension " + std::to_string(n));
    Independence independence;
    for (std::uint32_t pixel = 0; pixel < kKeys; ++pixel) {
      const std::uint32_t first = surface_key(pixel);
      const std::uint32_t second = hash_combine(first, dimension(Dimension::kNextSurface, 1));
      const std::uint32_t third = hash_combine(second, dimension(Dimension::kNextSurface, 2));
      independence.add(draws(first, n), draws(second, n));
      independence.add(draws(second, n), draws(third, n));
      independence.add(draws(first, n), draws(third, n));
    }
    independence.expect();
  }
}

// Shows that the tests above can fail: without the shuffle two dimensions are one sequence.
TEST(Dimensions, UsesOfOneOrderAreFoundOut) {
  Independence independence;
  for (std::uint32_t pixel = 0; pixel < kKeys; ++pixel) {
    std::vector<Vec2f> a(kDraws), b(kDraws);
    for (std::uint32_t i = 0; i < kDraws; ++i) {
      a[i] = sample_2d(hash_combine(surface_key(pixel), 1), i);
      b[i] = sample_2d(hash_combine(surface_key(pixel), 2), i);
    }
    independence.add(a, b);
  }
  EXPECT_GT(independence.excess(), independence.allowed());
  EXPECT_GT(independence.excess(), kCells);
}

}  // namespace
}  // namespace tessera::core
