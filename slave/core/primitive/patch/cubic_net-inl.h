// SPDX-License-Identifier: Apache-2.0
// Nets of four by four control points as polynomials of two variables in Bernstein form: ranges,
// parts; and vectors of three.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_CUBIC_NET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_NET_INL_H_
#undef TESSERA_CORE_CUBIC_NET_INL_H_
#else
#define TESSERA_CORE_CUBIC_NET_INL_H_
#endif

#include "slave/core/primitive/patch/quad-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Vectors of three.
struct Triple {
  double x, y, z;
};
HWY_INLINE Triple operator*(double a, Triple v) { return {a * v.x, a * v.y, a * v.z}; }
HWY_INLINE double dot_of(Triple a, Triple b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE Triple cross_of(Triple a, Triple b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HWY_INLINE double length_of(Triple a) { return __builtin_sqrt(dot_of(a, a)); }
HWY_INLINE Triple unit_of(Triple a) { return (1 / length_of(a)) * a; }

// Row i, column j: of B_i(u) B_j(v).
struct CubicNet {
  Quad row[4];

  HWY_INLINE CubicNet transposed() const {
    CubicNet other;
    transpose(row, other.row);
    return other;
  }
  HWY_INLINE void range(double& low, double& high) const {
    low = min(min(row[0], row[1]), min(row[2], row[3])).least();
    high = max(max(row[0], row[1]), max(row[2], row[3])).greatest();
  }
  // The range of the derivative by the parameter of the rows, where the square is [-1, 1]^2.
  HWY_INLINE void slope_range(double& low, double& high) const {
    const Quad a = row[1] - row[0], b = row[2] - row[1], c = row[3] - row[2];
    low = 1.5 * min(min(a, b), c).least();
    high = 1.5 * max(max(a, b), c).greatest();
  }
  // Keeps [from, to] of the parameter of the rows, by de Casteljau's scheme.
  HWY_INLINE void restrict_rows(double from, double to) {
    // The cut that leaves more comes first, so that the other's share is no quotient of small ones.
    if (from + to >= 1) {
      if (to != 1) keep_low(to);
      if (from != 0) keep_high(from / to);
    } else {
      if (from != 0) keep_high(from);
      if (to != 1) keep_low((to - from) / (1 - from));
    }
  }
  HWY_INLINE void keep_low(double a) {
    for (int k = 1; k <= 3; ++k)
      for (int i = 3; i >= k; --i) row[i] = (1 - a) * row[i - 1] + a * row[i];
  }
  HWY_INLINE void keep_high(double a) {
    for (int k = 1; k <= 3; ++k)
      for (int i = 0; i <= 3 - k; ++i) row[i] = (1 - a) * row[i] + a * row[i + 1];
  }
};

struct CubicBox {
  double low[2], high[2];  // in the sub-patch's square
  CubicNet f[2];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
