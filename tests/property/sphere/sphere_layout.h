// SPDX-License-Identifier: Apache-2.0
// A kind of primitive that only tests build: balls, hit at their surface. It shows what a new kind
// takes, which is this folder and no change to slave/core.
// Fixed-size types only.
#pragma once

#include <stdint.h>

namespace tessera::core {

// W balls; radius NaN where there are fewer.
template <int W>
struct alignas(W * sizeof(float)) SphereBlock {
  float center[3][W];
  float radius[W];
  uint32_t primitive[W];
};

// Scenes of balls alone: the number of a block is that of a sphere block.
template <int W>
struct SpheresOnly {
  const SphereBlock<W>* spheres;
};

// Distance at which a ray meets a ball within [t_min, t_max]. It is computed in double and without
// fused operations, so that it depends on nothing but the two. Returns: infinity where they do not
// meet; never NaN.
inline float sphere_t(const float* origin, const float* direction, const float* center,
                      float radius, float t_min, float t_max) {
  double a = 0, b = 0, c = -static_cast<double>(radius) * static_cast<double>(radius);
  for (int k = 0; k < 3; ++k) {
    const double o = static_cast<double>(origin[k]) - static_cast<double>(center[k]);
    const double d = static_cast<double>(direction[k]);
    a += d * d;
    b += o * d;
    c += o * o;
  }
  const double discriminant = b * b - a * c;
  const float none = __builtin_inff();
  if (!(discriminant >= 0)) return none;
  const double root = __builtin_sqrt(discriminant);
  const double q = b < 0 ? root - b : -(root + b);  // the sum that does not cancel
  const double first = b < 0 ? c / q : q / a, second = b < 0 ? q / a : c / q;
  const auto in_range = [&](double t) {
    return static_cast<float>(t) >= t_min && static_cast<float>(t) <= t_max;
  };
  if (in_range(first)) return static_cast<float>(first);
  return in_range(second) ? static_cast<float>(second) : none;
}

}  // namespace tessera::core
