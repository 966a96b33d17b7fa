// SPDX-License-Identifier: Apache-2.0
// Which of several rays from one point meet a triangle, as far as double can tell: a register of
// rays at a time, by the operations with which exact_hit() begins and with its bound on their
// error. What is the same for all rays, the triangle's edges seen from the point, is computed once.
//
// Threads. Values.
#include "slave/core/primitive/triangle/exact_hit_abi.h"

#if defined(TESSERA_CORE_EDGE_SIDES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_EDGE_SIDES_INL_H_
#undef TESSERA_CORE_EDGE_SIDES_INL_H_
#else
#define TESSERA_CORE_EDGE_SIDES_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class EdgeSides {
 public:
  static constexpr size_t kRays = kLanesOf<Doubles>;
  // Bits of rays: those that it is known of whether they meet the triangle, and those of them that
  // do.
  struct Found {
    uint32_t known, met;
  };

  // Shape: origin [3], triangle [9] (A, B, C).
  EdgeSides(const float* origin, const float* triangle);
  // Shape: direction [axis][ray].
  HWY_INLINE Found of(const float (*direction)[kRays]) const;

 private:
  double normal_[3][3];  // by edge: of the plane through the origin and the edge
  double size_[3][3];    // sums of the sizes of the two products in each component of that
};

inline EdgeSides::EdgeSides(const float* origin, const float* triangle) {
  double to[3][3];
  for (int c = 0; c < 3; ++c) {
    for (int a = 0; a < 3; ++a)
      to[c][a] = static_cast<double>(triangle[3 * c + a]) - static_cast<double>(origin[a]);
  }
  for (int c = 0; c < 3; ++c) {
    const double *const q = to[c], *const r = to[(c + 1) % 3];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const double a = q[j] * r[k], b = q[k] * r[j];
      normal_[c][i] = a - b;
      size_[c][i] = abs_of(a) + abs_of(b);
    }
  }
}

HWY_INLINE EdgeSides::Found EdgeSides::of(const float (*direction)[kRays]) const {
  const Doubles d[3] = {in_double(direction[0]), in_double(direction[1]), in_double(direction[2])};
  uint32_t left = 0, right = 0, sure = ~0u;
  for (int c = 0; c < 3; ++c) {
    const double *const n = normal_[c], *const s = size_[c];
    const Doubles value = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
    const Doubles size = abs(d[0]) * s[0] + abs(d[1]) * s[1] + abs(d[2]) * s[2];
    const auto is_sure = abs(value) > size * kDeterminantError;
    sure &= bits_of<Doubles>(is_sure);
    left |= bits_of<Doubles>(is_sure && value < 0);
    right |= bits_of<Doubles>(is_sure && value > 0);
  }
  const uint32_t outside = left & right;
  return {sure | outside, sure & ~outside};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
