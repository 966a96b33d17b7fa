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

// What the control points of a cubic count in those of its part over [from, to]: number k is the
// blossom of 3 - k times `from` and k times `to`. In [0, 1] all are sums of numbers that are not
// negative, so a cut adds a few roundings to a net, and [0, 1] itself changes none of it.
// T: double, or a register of doubles.
template <class T>
struct CubicCut {
  T weight[4][4];

  HWY_INLINE CubicCut(T s, T t) {
    const T p = 1 - s, q = 1 - t, ss = s * s, pp = p * p, tt = t * t, qq = q * q;
    const T ps = 2 * (p * s), qt = 2 * (q * t);
    put(0, pp * p, 3 * (pp * s), 3 * (p * ss), ss * s);
    put(1, pp * q, ps * q + pp * t, ss * q + ps * t, ss * t);
    put(2, p * qq, s * qq + p * qt, s * qt + p * tt, s * tt);
    put(3, qq * q, 3 * (qq * t), 3 * (q * tt), tt * t);
  }

 private:
  HWY_INLINE void put(int k, T a, T b, T c, T d) {
    weight[k][0] = a;
    weight[k][1] = b;
    weight[k][2] = c;
    weight[k][3] = d;
  }
};

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
  // Keeps [from, to] of the parameter of the rows.
  HWY_INLINE void restrict_rows(double from, double to) {
    const CubicCut<double> cut(from, to);
    const Quad old[4] = {row[0], row[1], row[2], row[3]};
    for (int k = 0; k < 4; ++k) {
      const double* const w = cut.weight[k];
      row[k] = (w[0] * old[0] + w[1] * old[1]) + (w[2] * old[2] + w[3] * old[3]);
    }
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
