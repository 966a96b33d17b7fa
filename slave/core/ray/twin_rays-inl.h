// SPDX-License-Identifier: Apache-2.0
// Two fans of shadow rays from one point that go nearly the same way, seen as one frustum: boxes
// and primitives are culled once for both, then tested with the rays of each.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_TWIN_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TWIN_RAYS_INL_H_
#undef TESSERA_CORE_TWIN_RAYS_INL_H_
#else
#define TESSERA_CORE_TWIN_RAYS_INL_H_
#endif

#include "slave/core/ray/fan_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Two neighbours of ShadowFans.
struct ShadowTwins {
  HWY_INLINE ShadowTwins(const ShadowFans& all, int g) : fan{{all, g}, {all, g + 1}} {}

  ShadowFan fan[2];
};

struct TwinRays : Frustum {
  static constexpr size_t kFans = 2;
  static constexpr int kStepsMax = FanRays::kStepsMax;

  // Returns: whether both are fans, and close to each other.
  bool setup(const ShadowTwins& twins);
  HWY_INLINE FanRays& fan(size_t f) { return fans_[f]; }
  const FanRays& fan(size_t f) const { return fans_[f]; }
  // As in FanRays.
  HWY_INLINE void shorten();
  HWY_INLINE void narrow();

  // As in FanRays, for the rays of both.
  Diagonals diagonals;
  int count = 0, work_left = 0;
  int32_t excluded = -1;
  float steepness = 0, widest[2], nearest_min;

 private:
  // Bounds the rays of both.
  HWY_INLINE void join();

  FanRays fans_[2];
};

inline bool TwinRays::setup(const ShadowTwins& twins) {
  const FanRays &one = fans_[0], &other = fans_[1];
  if (twins.fan[0].face != twins.fan[1].face) return false;
  if (!fans_[0].setup(twins.fan[0]) || !fans_[1].setup(twins.fan[1])) return false;
  static_cast<Frustum&>(*this) = one;
  join();
  const auto size = [](const Frustum& f) {
    return f.slope_u[1] - f.slope_u[0] + (f.slope_v[1] - f.slope_v[0]);
  };
  if (size(*this) > size(one) + size(other)) return false;
  for (int k = 0; k < 2; ++k) widest[k] = max_of(one.widest[k], other.widest[k]);
  steepness = 1 + widest[0] + widest[1];
  nearest_min = min_of(one.nearest_min, other.nearest_min);
  count = one.count + other.count;
  excluded = one.excluded;
  z_far = max_of(one.z_far, other.z_far);
  return true;
}

HWY_INLINE void TwinRays::join() {
  const FanRays &one = fans_[0], &other = fans_[1];
  const auto widest_of = [](const float* a, const float* b, float* to) {
    to[0] = min_of(a[0], b[0]);
    to[1] = max_of(a[1], b[1]);
  };
  widest_of(one.slope_u, other.slope_u, slope_u);
  widest_of(one.slope_v, other.slope_v, slope_v);
  widest_of(one.diagonals.sum, other.diagonals.sum, diagonals.sum);
  widest_of(one.diagonals.difference, other.diagonals.difference, diagonals.difference);
}

HWY_INLINE void TwinRays::narrow() {
  for (FanRays& fan : fans_) fan.narrow();
  join();
}

HWY_INLINE void TwinRays::shorten() {
  for (FanRays& fan : fans_) fan.shorten();
  z_far = max_of(fans_[0].z_far, fans_[1].z_far);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
