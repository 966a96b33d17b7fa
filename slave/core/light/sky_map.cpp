// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/sky_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/rounding.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr double kEvenShare = 0.1;
constexpr float kTwoPi2 = 19.7392088f;  // 2 pi^2: the picture's sides as angles, multiplied

double luminance(Vec3f c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// The mean over a texel of a bilinear picture, along one axis.
constexpr double kTent[3] = {0.125, 0.75, 0.125};

struct Picked {
  std::size_t number;
  float rest;
};

// The last i < count whose sum is at most i-th of `count` equal parts of [0, 1]: where to begin to look
// for what lies there (Chen and Asau, "On generating random variates from an empirical distribution",
// AIIE Transactions 6(2), 1974).
void set_guide(const double* sums, std::size_t count, std::uint16_t* guide) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(count);
    while (number + 1 < count && sums[number + 1] <= x) ++number;
    guide[i] = static_cast<std::uint16_t>(number);
  }
}

// sums [count + 1], from 0 to 1. 0 <= x < 1: the mean number of steps is 2 at most.
Picked pick(const double* sums, const std::uint16_t* guide, std::size_t count, float x) {
  const auto part = static_cast<std::size_t>(double{x} * static_cast<double>(count));
  std::size_t number = guide[std::min(part, count - 1)];
  // Where x times count has been rounded up to a whole number, it is one part too far.
  while (number > 0 && sums[number] > x) --number;
  while (number + 1 < count && sums[number + 1] <= x) ++number;
  const double chance = sums[number + 1] - sums[number];
  const auto rest = static_cast<float>(chance > 0 ? (x - sums[number]) / chance : 0.5);
  return {number, std::clamp(rest, 0.0f, 1 - kUnitRoundoff)};
}

// From sums to chances that end at 1.
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
  power_ = light * kTwoPi2 / static_cast<double>(width * height);
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
  const float x = place.x - 0.5f, y = place.y - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const float right_share = x - left, bottom_share = y - top;
  const int column = static_cast<int>(left), row = static_cast<int>(top);
  const Vec3f above = texel(column, row) * (1 - right_share) + texel(column + 1, row) * right_share;
  const Vec3f below =
      texel(column, row + 1) * (1 - right_share) + texel(column + 1, row + 1) * right_share;
  return above * (1 - bottom_share) + below * bottom_share;
}

float SkyMap::chance(std::size_t x, std::size_t y) const {
  const auto width = static_cast<std::size_t>(map_->width_px);
  const double* columns = &columns_[y * (width + 1)];
  return static_cast<float>((rows_[y + 1] - rows_[y]) * (columns[x + 1] - columns[x]) *
                            static_cast<double>(width) * map_->height_px);
}

SkyMap::Sample SkyMap::sample(Vec2f square) const {
  const auto width = static_cast<std::size_t>(map_->width_px);
  const auto height = static_cast<std::size_t>(map_->height_px);
  const Picked row = pick(rows_.data(), row_guide_.data(), height, square.y);
  const Picked column = pick(&columns_[row.number * (width + 1)],
                             &column_guide_[row.number * width], width, square.x);
  const Vec2f place{static_cast<float>(column.number) + column.rest,
                    static_cast<float>(row.number) + row.rest};
  const SinCos polar = sin_cos_whole_turn(place.y / static_cast<float>(height) / 2);
  const SinCos turn = sin_cos_whole_turn(place.x / static_cast<float>(width));
  // Column 0 looks along +z, the middle one along -z.
  const Vec3f direction{-polar.sin * turn.sin, polar.cos, polar.sin * turn.cos};
  const float likelier = chance(column.number, row.number);
  return {direction, at(place), likelier > 0 ? kTwoPi2 * polar.sin / likelier : 0};
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
