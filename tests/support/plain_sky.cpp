// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_sky.h"

#include <algorithm>
#include <cmath>

namespace tessera::test {
namespace {

constexpr float kPi = 3.14159274f;
constexpr float kTwoPi2 = 19.7392088f;  // 2 pi^2: the picture's sides as angles, multiplied

// Arc tangent of x in [0, 1]; off by 2e-8 (Abramowitz and Stegun, 4.4.49) and roundings.
float arc_tangent(float x) {
  const float b = x * x;
  float sum = 0.0028662257f;
  for (const float c : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                        -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.0f}) {
    sum = sum * b + c;
  }
  return x * sum;
}

// The angle of (x, y) from the x axis, y >= 0: in [0, pi]. 0 for (0, 0).
float half_angle_of(float x, float y) {
  const float ax = std::fabs(x);
  if (ax == 0 && y == 0) return 0;
  const float a = y <= ax ? arc_tangent(y / ax) : kPi / 2 - arc_tangent(ax / y);
  return x < 0 ? kPi - a : a;
}

// Place of a direction in the picture, in texels from the upper left corner.
Vec2f place_of(const core::SkyView& sky, Vec3f d) {
  const float turn = half_angle_of(-d.z, std::fabs(d.x)) / (2 * kPi);
  const float polar = half_angle_of(d.y, std::sqrt(d.x * d.x + d.z * d.z)) / kPi;
  return {(d.x < 0 ? 0.5f - turn : 0.5f + turn) * static_cast<float>(sky.width),
          polar * static_cast<float>(sky.height)};
}

}  // namespace

Vec3f plain_radiance(const core::SkyMap& sky, Vec3f direction) {
  return sky.at(place_of(sky.view(), direction));
}

float plain_pdf(const core::SkyMap& map, Vec3f direction) {
  const core::SkyView sky = map.view();
  const Vec2f place = place_of(sky, direction);
  const auto inside = [](float x, int count) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(x), 0, count - 1));
  };
  const std::size_t x = inside(place.x, sky.width), y = inside(place.y, sky.height);
  const double* const columns = sky.columns + y * (static_cast<std::size_t>(sky.width) + 1);
  const auto likelier = static_cast<float>((sky.rows[y + 1] - sky.rows[y]) *
                                           (columns[x + 1] - columns[x]) * sky.width * sky.height);
  const float sine = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  return sine > 0 ? likelier / (kTwoPi2 * sine) : 0;
}

}  // namespace tessera::test
