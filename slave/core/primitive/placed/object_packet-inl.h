// SPDX-License-Identifier: Apache-2.0
// The rays of a packet in the object space of a place, one by one, where sub-patches are left out
// that they surely pass.
//
// Room. A sub-patch in the world is S' = M S + T + E, with E the patch of the roundings of control
// points, which lies in their hull. So a point w of it that a ray meets comes back as A (w - T),
// within InstanceBlock::pad of the point s of S, where the pad was made with the box of all control
// points. The ray, as it is computed here, passes A (w - T) within 6 u L + q' R at the same t
// (instance_rays-inl.h; t stays, for the direction is not scaled), so it passes s within P by axis.
// In the frame of the part, by the largest P of an axis, that is N_r P by row. With s = (x, y, 0) +
// rest the ray is within reach_n + N_n P of the plane n = 0 at that t, and where it passes the
// plane it is away from the square by reach_a + N_a P + |p| (reach_n + N_n P) at most, by x, and so
// by y: the test of patch_filter-inl.h with P added to its room, which is its distance times 16 u.
// The same holds in the hull of the control points (patch_hull-inl.h), since seen along the ray
// what is off by P is off by (N_a + |p| N_n) P.
//
// Rays that cannot be taken to object space with that precision stay.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/instance_layout.h"

#if defined(TESSERA_CORE_OBJECT_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_OBJECT_PACKET_INL_H_
#undef TESSERA_CORE_OBJECT_PACKET_INL_H_
#else
#define TESSERA_CORE_OBJECT_PACKET_INL_H_
#endif

#include "slave/core/primitive/freeform/patch_filter-inl.h"
#include "slave/core/primitive/instance/instance_rays-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Rays: FanRays or BundleRays. The packet's own rays tell how far they look.
template <class Rays>
class ObjectPacket {
  using V = Floats;

 public:
  HWY_INLINE explicit ObjectPacket(const Rays& rays) : rays_(rays) {}

  // Takes the rays there. box: of the surface.
  HWY_NOINLINE void enter(const InstanceBlock& place, const SceneBox& box) {
    for (size_t at = 0; at < kPacketRays; at += kLaneCount) enter_row(place, box, at);
  }

  // What PatchFilter asks of rays.
  HWY_INLINE V farthest(size_t at) const { return rays_.farthest(at); }
  HWY_INLINE V farther(size_t at) const { return load<V>(farther_ + at); }
  const Rays& rays() const { return rays_; }

  alignas(64) float from[3][kPacketRays];
  alignas(64) float direction[3][kPacketRays];

 private:
  HWY_INLINE void enter_row(const InstanceBlock& place, const SceneBox& box, size_t at);
  // The origins of the rays from `at` on less T, by axis.
  static HWY_INLINE V moved(const FanRays& rays, const InstanceBlock& place, int a, size_t) {
    return set<V>(rays.origin[a] - place.to_world[a][3]);
  }
  static HWY_INLINE V moved(const BundleRays& rays, const InstanceBlock& place, int a, size_t at) {
    return load<V>(rays.from[a] + at) - place.to_world[a][3];
  }

  const Rays& rays_;
  alignas(64) float farther_[kPacketRays];
};

template <class Rays>
HWY_INLINE Floats least_ts(const ObjectPacket<Rays>& packet, size_t at) {
  return least_ts(packet.rays(), at);
}

// The room has seven roundings more than P's terms, for which there are 64 u, beside those of the
// sums in the filter. Directions below 2^-60 stay, and surfaces beyond 2^60: rows of the frames of
// parts are above 2^-65 otherwise, so that what underflows in the filter, at most 2^-148, is below
// the roundings that it allows for, 16 u of 2^-125.
template <class Rays>
void ObjectPacket<Rays>::enter_row(const InstanceBlock& place, const SceneBox& box, size_t at) {
  V o[3] = {}, d[3] = {}, around[3] = {}, size[3] = {};
  V far = set<V>(0), speed = far;
  for (int b = 0; b < 3; ++b) {
    o[b] = moved(rays_, place, b, at);
    d[b] = load<V>(rays_.direction[b] + at);
  }
  for (size_t a = 0; a < 3; ++a) {
    const auto along = [&](const V(&v)[3]) HWY_ATTR {
      return mul_add(set<V>(place.to_object[0][a]), v[0],
                     mul_add(set<V>(place.to_object[1][a]), v[1], place.to_object[2][a] * v[2]));
    };
    const auto size_of = [&](const V(&v)[3]) HWY_ATTR {
      return abs(place.to_object[0][a] * v[0]) + abs(place.to_object[1][a] * v[1]) +
             abs(place.to_object[2][a] * v[2]);
    };
    const V origin = along(o), toward = along(d);
    store(origin, from[a] + at);
    store(toward, direction[a] + at);
    around[a] = kPlacedOriginError * size_of(o) + place.pad[a];
    size[a] = size_of(d);
    const V away = max(abs(box.lower[a] - origin), abs(box.upper[a] - origin));
    far = max(far, 2 * around[a] + away);
    speed = max(speed, abs(toward));
  }
  V off = set<V>(0), worst = off;
  for (size_t a = 0; a < 3; ++a) {
    const V share = size[a] * (kPlacedDirectionError / speed);
    worst = max(worst, share);
    off = max(off, share * far + around[a]);
  }
  const auto is_near = far < 0x1p60f && speed > 0x1p-60f && speed < __builtin_inff() &&
                       worst <= kPlacedDirectionErrorMax;
  const V room = (off * (1 + 64 * kRoundoff) + kUnderflow) * PatchFilterRoom::kFartherPerOff;
  store(select(is_near, room, set<V>(__builtin_inff())), farther_ + at);
}

// One ray, as ObjectRay has it, for PatchRayFilter: its t is scaled, and all that depends on t. For
// P stands what corners may be off across a ray, which is more. Of what reaches as far as 2^60 no
// part is left out, as in packets. The limits of t are those for boxes, which are moved out.
struct ObjectSight {
  HWY_INLINE explicit ObjectSight(const ObjectRay& inner)
      : origin(inner.origin),
        direction(inner.slope),
        size(abs_of(inner.slope[0]) + abs_of(inner.slope[1]) + abs_of(inner.slope[2])),
        t_min(inner.near_limit),
        farther(inner.reach < 0x1p60f ? (inner.across() * (1 + 64 * kRoundoff) + kUnderflow) *
                                            PatchFilterRoom::kFartherPerOff
                                      : __builtin_inff()),
        best_t(inner.far_limit) {}

  // To be called after the ray was shortened.
  HWY_INLINE void shorten(const ObjectRay& inner) { best_t = inner.far_limit; }

  const float *origin, *direction;
  float size, t_min, farther, best_t;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
