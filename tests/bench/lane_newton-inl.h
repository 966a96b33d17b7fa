// SPDX-License-Identifier: Apache-2.0
// Newton for a bundle of rays in one register (thesis, 6.4.3), in float32.
//
// Threads. Pure functions, but for LaneScene::last.
#if defined(TESSERA_BENCH_LANE_NEWTON_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_BENCH_LANE_NEWTON_INL_H_
#undef TESSERA_BENCH_LANE_NEWTON_INL_H_
#else
#define TESSERA_BENCH_LANE_NEWTON_INL_H_
#endif

#include "tests/bench/lane_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Point and derivatives of a bicubic patch in powers of u and v.
template <class T>
struct LaneJet {
  T point[3], du[3], dv[3];
};

template <class T>
HWY_INLINE LaneJet<T> lane_jet(const LanePatch& patch, T u, T v) {
  LaneJet<T> jet;
  for (int a = 0; a < 3; ++a) {
    const float* p = patch.powers[a];
    T value[4], slope[4];
    for (int j = 0; j < 4; ++j) {
      const T two = set<T>(p[j]) * u + p[4 + j];
      const T quadratic = two * u + p[8 + j];
      value[j] = quadratic * u + p[12 + j];
      slope[j] = (set<T>(p[j]) * u + two) * u + quadratic;
    }
    const T two = value[0] * v + value[1], quadratic = two * v + value[2];
    jet.point[a] = quadratic * v + value[3];
    jet.dv[a] = (value[0] * v + two) * v + quadratic;
    jet.du[a] = ((slope[0] * v + slope[1]) * v + slope[2]) * v + slope[3];
  }
  return jet;
}

template <class T>
HWY_INLINE T dot3(const T (&a)[3], const T (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Newton for all rays of a bundle until each has ended. Starts: where each begins.
enum class LaneStart { kMiddle, kNeighbour, kSerial };

template <size_t kMost, LaneStart kFrom>
class LaneNewton {
  using T = FloatsOf<kMost>;
  using Rays = LaneRaysIn<kMost>;

 public:
  LaneNewton(const LaneScene& scene, const LaneHow& how, const LaneBundle& bundle, Rays& rays)
      : scene_(scene), how_(how), bundle_(bundle), rays_(rays) {}

  HWY_INLINE void test(uint32_t number, MaskOf<T> passing) {
    const LanePart& part = scene_.parts[number];
    if constexpr (kFrom == LaneStart::kSerial) {
      from_serial(number, part, passing);
    } else {
      float u = 0.5f * (part.low[0] + part.high[0]), v = 0.5f * (part.low[1] + part.high[1]);
      float* const last = scene_.last + 2 * number;
      if (kFrom == LaneStart::kNeighbour && last[0] == last[0]) {
        u = last[0];
        v = last[1];
      }
      const MaskOf<T> hit = iterate(number, part, passing, set<T>(u), set<T>(v));
      if (kFrom == LaneStart::kNeighbour && !is_none<T>(hit)) keep(hit, last);
    }
  }

 private:
  HWY_INLINE void keep(MaskOf<T> hit, float* last) const {
    alignas(64) float u[Rays::kCount], v[Rays::kCount];
    store(found_u_, u);
    store(found_v_, v);
    const int lane = __builtin_ctz(bits_of<T>(hit));
    last[0] = u[lane];
    last[1] = v[lane];
  }

  HWY_INLINE void from_serial(uint32_t number, const LanePart& part, MaskOf<T> passing) {
    alignas(64) float u[bench::kLaneStartsMax][Rays::kCount] = {},
                      v[bench::kLaneStartsMax][Rays::kCount] = {};
    uint32_t there[bench::kLaneStartsMax] = {};
    for (uint32_t bits = bits_of<T>(passing); bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const float d[3] = {bundle_.direction[0][i], bundle_.direction[1][i],
                          bundle_.direction[2][i]};
      float at_u[bench::kLaneStartsMax], at_v[bench::kLaneStartsMax];
      const int count = scene_.starts(scene_.owner, part.patch, d, at_u, at_v);
      for (int k = 0; k < count; ++k) {
        u[k][i] = at_u[k];
        v[k][i] = at_v[k];
        there[k] |= 1u << i;
      }
    }
    for (int k = 0; k < bench::kLaneStartsMax && there[k] != 0; ++k)
      iterate(number, part, mask_of<T>(there[k]), load<T>(u[k]), load<T>(v[k]));
  }

  HWY_INLINE MaskOf<T> iterate(uint32_t number, const LanePart& part, MaskOf<T> active, T u, T v) {
    const LanePatch& patch = scene_.patches[part.patch];
    const T flat = set<T>(how_.accuracy * patch.extent);
    T before = set<T>(__builtin_inff()), t = set<T>(0);
    MaskOf<T> hit = active && !active;
    for (int step = 0; step < 12 && !is_none<T>(active); ++step) {
      const LaneJet<T> jet = lane_jet(patch, u, v);
      const T f = dot3(rays_.normal[0], jet.point), g = dot3(rays_.normal[1], jet.point);
      const T fu = dot3(rays_.normal[0], jet.du), fv = dot3(rays_.normal[0], jet.dv);
      const T gu = dot3(rays_.normal[1], jet.du), gv = dot3(rays_.normal[1], jet.dv);
      const T away = max(abs(f), abs(g));
      active = active && away <= before;
      before = away;
      const MaskOf<T> is_there = active && away <= flat;
      const T inverse = 1 / (fu * gv - fv * gu);
      const T du = (fv * g - gv * f) * inverse, dv = (gu * f - fu * g) * inverse;
      t = select(is_there, dot3(rays_.d, jet.point) * rays_.per_square, t);
      u = select(active, u + du, u);
      v = select(active, v + dv, v);
      hit = hit || is_there;
      active = active && !is_there;
    }
    const float room[2] = {kLaneOverlap * (part.high[0] - part.low[0]),
                           kLaneOverlap * (part.high[1] - part.low[1])};
    hit = hit && u >= set<T>(part.low[0] - room[0]) && u <= set<T>(part.high[0] + room[0]) &&
          v >= set<T>(part.low[1] - room[1]) && v <= set<T>(part.high[1] + room[1]);
    found_u_ = u;
    found_v_ = v;
    rays_.take(hit, t, u, v, number);
    return hit;
  }

  const LaneScene& scene_;
  const LaneHow& how_;
  const LaneBundle& bundle_;
  Rays& rays_;
  T found_u_{}, found_v_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
