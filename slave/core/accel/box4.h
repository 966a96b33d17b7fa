// SPDX-License-Identifier: Apache-2.0
// Boxes as two registers of four floats, for builders: the fourth lane is not used. SSE2 is part of
// every 64-bit x86 processor, so this needs no choice at run time.
//
// Threads. Plain values.
#pragma once

#include <emmintrin.h>

#include <limits>

#include "common/math/bounds3.h"

namespace tessera::core {

struct Float4 {
  __m128 v;
  float operator[](int axis) const {
    alignas(16) float lanes[4];
    _mm_store_ps(lanes, v);
    return lanes[axis];
  }
};

inline Float4 load4(const float* aligned) { return {_mm_load_ps(aligned)}; }
inline Float4 splat4(float value) { return {_mm_set1_ps(value)}; }
inline Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
inline Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
inline Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }

struct Box4 {
  Float4 lower = splat4(std::numeric_limits<float>::infinity());
  Float4 upper = splat4(-std::numeric_limits<float>::infinity());

  // A lane that is NaN leaves the box as it is.
  void grow(Float4 low, Float4 high) {
    lower.v = _mm_min_ps(low.v, lower.v);
    upper.v = _mm_max_ps(high.v, upper.v);
  }
  void grow(const Box4& box) { grow(box.lower, box.upper); }
  // Leaves what is in `box`, too.
  void shrink(const Box4& box) {
    lower.v = _mm_max_ps(lower.v, box.lower.v);
    upper.v = _mm_min_ps(upper.v, box.upper.v);
  }
  // Returns: half the surface area; 0 for an empty box.
  float half_area() const {
    const Float4 extent{_mm_max_ps(_mm_sub_ps(upper.v, lower.v), _mm_setzero_ps())};
    return extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0];
  }
  Bounds3f bounds() const {
    return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
  }
};

}  // namespace tessera::core
