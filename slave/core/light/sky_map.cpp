// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/sky_map.h"

#define TESSERA_PLAIN_TEXT

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/core/light/sky-inl.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr double kEvenShare = 0.1;

double luminance(Vec3f c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// Weights of neighbours along one axis in the mean of a bilinear picture over a texel.
constexpr double kTent[3] = {0.125, 0.75, 0.125};

// guide[i] becomes the last number below `count` whose sum is at most i / count. There begins the
// search for what lies in the i-th of `count` equal parts of [0, 1] (Chen and Asau, "On generating
// random variates from an empirical distribution", AIIE Transactions 6(2), 1974).
void set_guide(const double* sums, std::size_t count, std::uint16_t* guide) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(count);
    while (number + 1 < count && sums[number + 1] <= x) ++number;
    guide[i] = static_cast<std::uint16_t>(number);
  }
}

// Turns sums into cumulative chances that end at 1; sums that are all 0 become even chances.
void normalise(const double* sums, std::size_t count, double* to) {
  for (std::size_t i = 0; i <= count; ++i)
    to[i] = sums[count] > 0 ? sums[i] / sums[count]
                            : static_cast<double>(i) / static_cast<double>(count);
}

}  // namespace

SkyMap::SkyMap(std::shared_ptr<const EnvironmentMap> map) : map_(std::move(map)) {
  const auto width = static_cast<std::size_t>(map_->width_px);
  const auto height = static_cast<std::size_t>(map_->height_px);
  rows_.resize(height + 1);
  columns_.resize(height * (width + 1));
  row_guide_.resize(height);
  column_guide_.resize(height * width);
  const auto sine_of = [&](std::size_t y) {
    const float middle = (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    return double{sin_cos_whole_turn(middle / 2).sin};
  };
  double sines = 0, light = 0;  // of all texels
  for (std::size_t y = 0; y < height; ++y) {
    sines += sine_of(y) * static_cast<double>(width);
    for (std::size_t x = 0; x < width; ++x)
      light += sine_of(y) * weight_of(static_cast<int>(x), static_cast<int>(y));
  }
  power_ = light * plain::SkyPicture<float>::kTwoPi2 / static_cast<double>(width * height);
  const double even = light / sines * kEvenShare / (1 - kEvenShare);
  std::vector<double> sums(width + 1), rows(height + 1);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x)
      sums[x + 1] = sums[x] + weight_of(static_cast<int>(x), static_cast<int>(y)) + even;
    normalise(sums.data(), width, &columns_[y * (width + 1)]);
    set_guide(&columns_[y * (width + 1)], width, &column_guide_[y * width]);
    rows[y + 1] = rows[y] + sums[width] * sine_of(y);
  }
  normalise(rows.data(), height, rows_.data());
  set_guide(rows_.data(), height, row_guide_.data());
}

Vec3f SkyMap::texel(int x, int y) const {
  const int row = std::clamp(y, 0, map_->height_px - 1), width = map_->width_px;
  const int column = x < 0 ? x + width : x < width ? x : x - width;
  const float* c =
      &map_->rgb[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(map_->width_px) +
                      static_cast<std::size_t>(column))];
  return {c[0], c[1], c[2]};
}

double SkyMap::weight_of(int x, int y) const {
  double sum = 0;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) sum += kTent[i] * kTent[j] * luminance(texel(x + i - 1, y + j - 1));
  }
  return sum;
}

Vec3f SkyMap::at(Vec2f place) const {
  return plain::SkyPicture<float>(view()).radiance_at({place.x, place.y}, 1);
}

SkyMap::Sample SkyMap::sample(Vec2f square) const {
  const auto sample = plain::SkyPicture<float>(view()).sample(&square.x, &square.y, 1);
  return {sample.direction, sample.radiance, sample.angle};
}

SkyView SkyMap::view() const {
  return {map_->rgb.data(), map_->width_px,    map_->height_px,     rows_.data(),
          columns_.data(),  row_guide_.data(), column_guide_.data()};
}

std::uint64_t SkyMap::memory_bytes() const {
  return map_->rgb.size() * sizeof(float) + (rows_.size() + columns_.size()) * sizeof(double) +
         (row_guide_.size() + column_guide_.size()) * sizeof(std::uint16_t);
}

}  // namespace tessera::core
