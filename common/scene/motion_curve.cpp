// SPDX-License-Identifier: Apache-2.0
#include "common/scene/motion_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tessera {
namespace {

// Sum of the sine's series. On [0, pi/2] the first term left out is below 2e-21.
double sine(double x) {
  constexpr int kTerms = 12;
  double sum = 0;
  for (int k = kTerms; k >= 1; --k) sum = 1 - x * x / ((2 * k) * (2 * k + 1)) * sum;
  return x * sum;
}

// Arcus sine of y in [0, 1/sqrt(2) and some]. Halving the angle twice leaves at most 0.196, where
// the first term left out of the series is below 1e-18.
double arc_sine(double y) {
  constexpr int kHalvings = 2, kTerms = 11;
  for (int i = 0; i < kHalvings; ++i) {
    const double cosine = std::sqrt(std::max(0.0, 1 - y * y));
    y = y / std::sqrt(2 * (1 + cosine));
  }
  // The ratio of the series' terms k and k - 1 is y^2 (2k - 1)^2 / (2k (2k + 1)).
  double sum = 1;
  for (int k = kTerms; k >= 1; --k) {
    const double odd = 2 * k - 1;
    sum = 1 + y * y * odd * odd / (2.0 * k * (2.0 * k + 1)) * sum;
  }
  return (1 << kHalvings) * y * sum;
}

double squared_length(const Quaternion& q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

Quaternion rotation_at(const float* value) {
  return unit({static_cast<double>(value[0]), static_cast<double>(value[1]),
               static_cast<double>(value[2]), static_cast<double>(value[3])});
}

}  // namespace

Quaternion unit(const Quaternion& q) {
  const double size = std::sqrt(squared_length(q));
  if (!(size > 0) || !std::isfinite(size)) return {0, 0, 0, 1};
  return {q[0] / size, q[1] / size, q[2] / size, q[3] / size};
}

Quaternion slerp(const Quaternion& a, const Quaternion& b, double share) {
  const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const double sign = cosine < 0 ? -1 : 1;
  Quaternion difference;
  for (std::size_t i = 0; i < 4; ++i) difference[i] = sign * b[i] - a[i];
  // Half of the chord is the sine of half of the angle, and has all digits where angles are small.
  const double angle = 2 * arc_sine(0.5 * std::sqrt(squared_length(difference)));
  const double whole = sine(angle);
  const double from = whole > 0 ? sine((1 - share) * angle) / whole : 1 - share;
  const double to = sign * (whole > 0 ? sine(share * angle) / whole : share);
  Quaternion result;
  for (std::size_t i = 0; i < 4; ++i) result[i] = from * a[i] + to * b[i];
  return unit(result);
}

void sample_channel(const SceneAnimation& animation, const MotionChannel& channel, double seconds,
                    std::span<double> value) {
  const std::size_t width = value.size();
  const std::size_t stride = channel_width(animation, channel);
  const bool is_cubic = channel.curve == KeyCurve::kCubic;
  const bool is_rotation = channel.path == MotionPath::kRotation;
  const float* const keys = animation.key_seconds.data() + channel.first_key;
  const float* const values = animation.key_values.data() + channel.first_value;
  const auto value_of = [&](std::size_t key) {
    return values + key * stride + (is_cubic ? width : 0);
  };
  // The last key that is not later; `next` is the one behind it.
  const auto next = static_cast<std::size_t>(
      std::upper_bound(keys, keys + channel.key_count, seconds,
                       [](double t, float key) { return t < static_cast<double>(key); }) -
      keys);
  const std::size_t key = next == 0 ? 0 : next - 1;
  const float* const here = value_of(key);
  const bool is_held = next == 0 || next == channel.key_count || channel.curve == KeyCurve::kStep;
  if (is_held) {
    for (std::size_t i = 0; i < width; ++i) value[i] = static_cast<double>(here[i]);
  } else {
    const double began = static_cast<double>(keys[key]);
    const double span = static_cast<double>(keys[next]) - began;
    const double s = (seconds - began) / span;
    const float* const there = value_of(next);
    if (is_rotation && !is_cubic) {
      const Quaternion turned = slerp(rotation_at(here), rotation_at(there), s);
      std::copy(turned.begin(), turned.end(), value.begin());
    } else if (is_cubic) {
      const float* const out = here + width;  // tangents, a second
      const float* const in = there - width;
      for (std::size_t i = 0; i < width; ++i) {
        const double p0 = static_cast<double>(here[i]), p1 = static_cast<double>(there[i]);
        const double m0 = span * static_cast<double>(out[i]);
        const double m1 = span * static_cast<double>(in[i]);
        const double s2 = s * s, s3 = s2 * s;
        value[i] = (2 * s3 - 3 * s2 + 1) * p0 + (s3 - 2 * s2 + s) * m0 + (3 * s2 - 2 * s3) * p1 +
                   (s3 - s2) * m1;
      }
    } else {
      for (std::size_t i = 0; i < width; ++i) {
        const double from = static_cast<double>(here[i]);
        value[i] = from + s * (static_cast<double>(there[i]) - from);
      }
    }
  }
  if (!is_rotation) return;
  const Quaternion whole = unit({value[0], value[1], value[2], value[3]});
  std::copy(whole.begin(), whole.end(), value.begin());
}

}  // namespace tessera
