// SPDX-License-Identifier: Apache-2.0
// Nets of four by four numbers (cubic_net-inl.h), one in each lane of a register of doubles. Lanes
// do what CubicNet does, operation by operation, so the bits are the same.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_CUBIC_LANE_NET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_LANE_NET_INL_H_
#undef TESSERA_CORE_CUBIC_LANE_NET_INL_H_
#else
#define TESSERA_CORE_CUBIC_LANE_NET_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_net-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// A vector of three in each lane.
struct LaneTriple {
  Doubles x, y, z;
};
HWY_INLINE LaneTriple operator*(Doubles a, LaneTriple v) { return {a * v.x, a * v.y, a * v.z}; }
HWY_INLINE Doubles dot_of(LaneTriple a, LaneTriple b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE LaneTriple cross_of(LaneTriple a, LaneTriple b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HWY_INLINE Doubles length_of(LaneTriple a) { return sqrt(dot_of(a, a)); }
HWY_INLINE LaneTriple unit_of(LaneTriple a) { return (1 / length_of(a)) * a; }

// Bernstein polynomials of degree 3 at u, and their derivatives by what u is `half` times of.
HWY_INLINE void cubic_weights(Doubles u, Doubles half, Doubles (&weight)[4], Doubles (&slope)[4]) {
  const Doubles v = 1 - u, uu = u * u, vv = v * v, uv = 2 * (u * v), h = 3 * half;
  weight[0] = vv * v;
  weight[1] = 3 * (vv * u);
  weight[2] = 3 * (uu * v);
  weight[3] = uu * u;
  slope[0] = -h * vv;
  slope[1] = h * (vv - uv);
  slope[2] = h * (uv - uu);
  slope[3] = h * uu;
}

// A part of [0, 1] of one parameter, in each lane: what CubicNet::restrict_rows() takes.
struct LaneRange {
  Doubles from, to;

  static HWY_INLINE LaneRange whole() { return {set<Doubles>(0), set<Doubles>(1)}; }
  template <class M>
  HWY_INLINE void replace(M mask, Doubles low, Doubles high) {
    from = select(mask, low, from);
    to = select(mask, high, to);
  }
};

// Number (i, j), of B_i(u) B_j(v), is x[4 i + j].
struct CubicLaneNet {
  using V = Doubles;

  V x[16];

  HWY_INLINE void range(V& low, V& high) const {
    low = high = x[0];
    for (int k = 1; k < 16; ++k) {
      low = min(low, x[k]);
      high = max(high, x[k]);
    }
  }
  // The range of the derivative by one parameter, where the square is [-1, 1]^2.
  template <int kAxis>
  HWY_INLINE void slope_range(V& low, V& high) const {
    low = high = x[at<kAxis>(1, 0)] - x[at<kAxis>(0, 0)];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) {
        const V step = x[at<kAxis>(i + 1, j)] - x[at<kAxis>(i, j)];
        low = min(low, step);
        high = max(high, step);
      }
    low = 1.5 * low;
    high = 1.5 * high;
  }
  template <int kAxis>
  HWY_INLINE void cut(const CubicCut<V>& cut) {
    for (int j = 0; j < 4; ++j) {
      const V old[4] = {x[at<kAxis>(0, j)], x[at<kAxis>(1, j)], x[at<kAxis>(2, j)],
                        x[at<kAxis>(3, j)]};
      for (int k = 0; k < 4; ++k)
        x[at<kAxis>(k, j)] = (cut.weight[k][0] * old[0] + cut.weight[k][1] * old[1]) +
                             (cut.weight[k][2] * old[2] + cut.weight[k][3] * old[3]);
    }
  }

 private:
  template <int kAxis>
  static constexpr int at(int i, int j) {
    return kAxis == 0 ? 4 * i + j : 4 * j + i;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
