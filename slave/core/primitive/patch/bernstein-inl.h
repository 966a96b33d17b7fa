// SPDX-License-Identifier: Apache-2.0
// Points and derivatives of patches, as one sequence of operations for each pair of degrees.
// T: double, or a register of doubles; other plain numbers where tests ask for them.
//
// Error. For x in [0, 1] all sums of bernstein() are of numbers of one sign, so a polynomial of
// degree d is good to 3 d roundings (R. Farouki, V. Rajan, "On the numerical condition of
// polynomials in Bernstein form", Computer Aided Geometric Design 4, 1987). A point takes two of
// them, two products, two sums of up to 16 terms and the quotient: 2 x 45 + 2 + 2 x 15 + 3 = 125,
// below 2^7 roundings of 2^-53 of the largest |P_ij| (weights are positive, so S is a mean of
// points): 2^-46 in all.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_BERNSTEIN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BERNSTEIN_INL_H_
#undef TESSERA_CORE_BERNSTEIN_INL_H_
#else
#define TESSERA_CORE_BERNSTEIN_INL_H_
#endif

#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/simd/real-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// What stands for an error of evaluation, of the largest coordinate: the 125 roundings above.
inline constexpr double kEvaluationError = 0x1p-46;

// A control point; its products are exact.
TESSERA_INLINE PatchPoint point_of(const Patch& patch, int number) {
  const float* const p = patch.numbers + (patch.is_rational ? 4 : 3) * number;
  const double w = patch.is_rational ? static_cast<double>(p[3]) : 1;
  return {{w * static_cast<double>(p[0]), w * static_cast<double>(p[1]),
           w * static_cast<double>(p[2]), w}};
}

// A point and its first derivatives.
template <class T>
struct PatchJet {
  T point[3], du[3], dv[3];
};

// Bernstein polynomials of the degree at x, and their derivatives.
// Shape: weight and slope [degree + 1]. Requires: degree >= 1.
template <class T>
TESSERA_INLINE void bernstein(int degree, T x, T* weight, T* slope) {
  const T y = 1 - x;
  weight[0] = set<T>(1);
  for (int k = 1; k <= degree; ++k) {
    if (k == degree) {  // the weights are those of one degree less
      const T d = set<T>(static_cast<LaneOf<T>>(degree));
      slope[0] = -d * weight[0];
      for (int i = 1; i < degree; ++i) slope[i] = d * (weight[i - 1] - weight[i]);
      slope[degree] = d * weight[degree - 1];
    }
    T carried = set<T>(0);
    for (int i = 0; i < k; ++i) {
      const T old = weight[i];
      weight[i] = carried + y * old;
      carried = x * old;
    }
    weight[k] = carried;
  }
}

// The sums over a net: [0] of point, [1] of d/du, [2] of d/dv, each of the first kComponents of
// w x, w y, w z, w.
template <class T, int kComponents>
struct NetSums {
  T of[3][kComponents];
};

// A number of a control point as a T: here of one net for all lanes.
template <class T>
TESSERA_INLINE T component_of(const PatchPoint* points, int number, int a) {
  return set<T>(static_cast<LaneOf<T>>(points[number].x[a]));
}

// kM, kN: the degrees where they are known when this is compiled, else 0. The operations are the
// same for the same degrees, either way. Points: what component_of() takes.
template <class T, int kComponents, int kM, int kN, class Points>
TESSERA_INLINE NetSums<T, kComponents> net_sums(Points points, int degree_u, int degree_v, T u,
                                                T v) {
  const int m = kM != 0 ? kM : degree_u, n = kN != 0 ? kN : degree_v;
  T bu[(kM != 0 ? kM : kPatchDegreeMax) + 1] = {}, su[(kM != 0 ? kM : kPatchDegreeMax) + 1] = {};
  T bv[(kN != 0 ? kN : kPatchDegreeMax) + 1] = {}, sv[(kN != 0 ? kN : kPatchDegreeMax) + 1] = {};
  bernstein(m, u, bu, su);
  bernstein(n, v, bv, sv);
  NetSums<T, kComponents> sums = {};
  for (int i = 0; i <= m; ++i) {
    for (int a = 0; a < kComponents; ++a) {
      const auto of_point = [&](int j) { return component_of<T>(points, (n + 1) * i + j, a); };
      T value = bv[0] * of_point(0), slope = sv[0] * of_point(0);
      for (int j = 1; j <= n; ++j) {
        value = value + bv[j] * of_point(j);
        slope = slope + sv[j] * of_point(j);
      }
      if (i == 0) {
        sums.of[0][a] = bu[0] * value;
        sums.of[1][a] = su[0] * value;
        sums.of[2][a] = bu[0] * slope;
      } else {
        sums.of[0][a] = sums.of[0][a] + bu[i] * value;
        sums.of[1][a] = sums.of[1][a] + su[i] * value;
        sums.of[2][a] = sums.of[2][a] + bu[i] * slope;
      }
    }
  }
  return sums;
}

template <class T, bool kRational, int kM, int kN, class Points>
TESSERA_INLINE PatchJet<T> evaluated(Points points, int degree_u, int degree_v, T u, T v) {
  const auto sums = net_sums < T, kRational ? 4 : 3, kM, kN > (points, degree_u, degree_v, u, v);
  PatchJet<T> jet = {};
  if constexpr (kRational) {
    const T inverse = 1 / sums.of[0][3];
    for (int a = 0; a < 3; ++a) {
      jet.point[a] = sums.of[0][a] * inverse;
      jet.du[a] = (sums.of[1][a] - jet.point[a] * sums.of[1][3]) * inverse;
      jet.dv[a] = (sums.of[2][a] - jet.point[a] * sums.of[2][3]) * inverse;
    }
  } else {
    for (int a = 0; a < 3; ++a) {
      jet.point[a] = sums.of[0][a];
      jet.du[a] = sums.of[1][a];
      jet.dv[a] = sums.of[2][a];
    }
  }
  return jet;
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
