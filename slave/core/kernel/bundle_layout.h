// Rays and hits as the kernels see them: bundles of 16 (4x4 pixels), one array per component.
// Fixed-size types only and no functions (see kd_layout.h).
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kBundleRays = 16;
inline constexpr uint32_t kNoPrimitive = 0xffffffffu;

// P(t) = origin + t * direction; the direction need not be normalised, t is in units of its length.
// A hit needs t_min <= t <= t_max; t_max may be infinite. A ray with a component that is not
// finite, a zero direction or limits that are NaN is a miss and touches no other ray.
struct alignas(64) RayBundle {
  float origin[3][kBundleRays];
  float direction[3][kBundleRays];
  float t_min[kBundleRays];
  float t_max[kBundleRays];
  uint32_t active;  // bit i: ray i is to be traced; the arrays need not be set for the others
};

// P = (1 - u - v) A + u B + v C. All zero where primitive is kNoPrimitive.
struct alignas(64) HitBundle {
  float t[kBundleRays];
  float u[kBundleRays];
  float v[kBundleRays];
  uint32_t primitive[kBundleRays];
};

}  // namespace tessera::core
