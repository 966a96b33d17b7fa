// SPDX-License-Identifier: Apache-2.0
// Rays taken into the object space of an instance, where they are tested against boxes, and rays by
// themselves are looked at beside triangles: what they hit is decided in world space.
//
// Padding. A point x of the world is y = A (x - T) in object space, with A = to_object exactly as
// it is stored and T the last column of to_world, so whatever A is, rays and corners are taken
// there by one map. Two things are off, both by axis and in object units:
//   corners  A (w - T) of a corner w in world space, rounded there, differs from the corner p of
//            the mesh, which its boxes hold, by at most InstanceBlock::pad
//            (instance_placement.cpp).
//   rays     with u = 2^-24: the origin o' = A (o - T) takes one rounding for o - T and three for
//            the row: 4 u L, L = |A| |o - T| by absolute values. The direction d' = A d takes
//            three: 3 u |A| |d|; at the parameter t where the ray is at the box, |t| <= R / |d'| by
//            main axis, with R the largest distance of a point of the (padded) box, that moves the
//            ray by q R, q = 3 u |A| |d| / |d'|.
// So boxes grow by P = pad + 6 u L + q' R with q' = 4 u |A| |d| / |d'|, for q' <= 1/4: then R,
// which knows nothing of the last term, still is large enough: (R + P) 3/4 q' <= q' R for P <= R /
// 3, and where pad and 6 u L make P larger, they are part of R.
//
// Triangles. A corner and the ray, both in object space, are off by E = pad + 6 u L on each axis,
// and the ray's direction by q |d'|. Across the ray, sheared along its main axis z, a corner of
// which nothing is farther than R is off by
//    E_x + E_z + R (q_x + q_z) / (1 - q_z) <= 4/3 (P_x + P_z),
// and its t by (E_z + R q_z / (1 - q_z)) / |d'| <= 4/3 P_z / |d'|. A line passes through a triangle
// where it does so after the map A, exactly; so a triangle whose edges are surely on one side in
// object space, by these, is hit in world space, too.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/instance_layout.h"

#if defined(TESSERA_CORE_INSTANCE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_INSTANCE_RAYS_INL_H_
#undef TESSERA_CORE_INSTANCE_RAYS_INL_H_
#else
#define TESSERA_CORE_INSTANCE_RAYS_INL_H_
#endif

#include "slave/core/ray/bundle_rays-inl.h"
#include "slave/core/ray/fan_rays-inl.h"
#include "slave/core/ray/one_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

constexpr float kPlacedOriginError = 6 * kRoundoff, kPlacedDirectionError = 4 * kRoundoff;
constexpr float kPlacedDirectionErrorMax = 0.25f;  // q'

// A ray in object space, as far as boxes need it.
class ObjectRay : public BoxRay {
 public:
  // Takes the ray there. Its direction is the scaled one, so that no transform makes it vanish or
  // overflow. Returns: false where that cannot be done with the precision that boxes need.
  // Requires: the ray is set up, and looks farther than it begins.
  HWY_INLINE bool enter(const OneRay& ray, const InstanceBlock& instance, const SceneBox& box) {
    const auto self = [&](size_t) { return this; };
    return enter_each<Axes<FloatsOf<4>>>(
        self, [&](size_t) { return &ray; }, [&](size_t) { return &instance; },
        [&](size_t) { return &box; });
  }
  // Takes as many rays as Axes holds. Returns: false where that cannot be done for one of them.
  template <class Axes, class To, class Ray, class Instance, class Box>
  static HWY_INLINE bool enter_each(const To& to, const Ray& ray, const Instance& instance,
                                    const Box& box);
  // To be called after hits.
  HWY_INLINE void shorten(const OneRay& ray) {
    far_limit = moved(ray.best_t * ray.scale * scale, 2 * kTimeSlack);
  }

  // What triangles of the mesh are off across this ray from where they are across the other, and
  // their t along it.
  float across() const { return 2.75f * off_; }
  float along() const { return 1.5f * off_ * abs_of(inverse[kz]); }

 private:
  float off_;  // the largest P of an axis
};

// The pad P, in t, joins what widens t anyway.
template <class Axes, class To, class Ray, class Instance, class Box>
bool ObjectRay::enter_each(const To& to, const Ray& ray, const Instance& instance, const Box& box) {
  const auto row = [&](size_t a) {
    return Axes::load_each([&, a](size_t r) { return instance(r)->to_world[a]; });
  };
  const auto column = [&](size_t a) {
    return Axes::load_each([&, a](size_t r) { return instance(r)->to_object[a]; });
  };
  const Axes x = column(0), y = column(1), z = column(2);
  const auto taken = [&](Axes v) {
    return x.mul_add(v.template component<0>(),
                     y.mul_add(v.template component<1>(), z * v.template component<2>()));
  };
  const auto size_of = [&](Axes v) {
    return (x * v.template component<0>()).size() + (y * v.template component<1>()).size() +
           (z * v.template component<2>()).size();
  };
  const Axes from = Axes::load_each([&](size_t r) { return ray(r)->origin; }) -
                    Axes::fourths(row(0), row(1), row(2));
  const Axes toward = Axes::load_each([&](size_t r) { return ray(r)->slope; });
  const Axes at = taken(from), along = taken(toward);
  const Axes own_pad = Axes::load_each([&](size_t r) { return instance(r)->pad; });
  const Axes around = size_of(from).mul_add(Axes::all(kPlacedOriginError), own_pad);
  const Axes low = (Axes::load_each([&](size_t r) { return box(r)->lower; }) - at).size();
  const Axes high = (Axes::load_each([&](size_t r) { return box(r)->upper; }) - at).size();
  const Axes far = around.mul_add(Axes::all(2), low.larger(high));
  const Axes reach = far.greatest(), speed = along.size().greatest();
  const Axes share = size_of(toward) * (Axes::all(kPlacedDirectionError) / speed);
  const bool is_near = (far < Axes::all(0x1p100f)).is_all() && (Axes::all(0) < speed).is_all() &&
                       (speed < Axes::all(__builtin_inff())).is_all() &&
                       (share <= Axes::all(kPlacedDirectionErrorMax)).is_all();
  if (HWY_UNLIKELY(!is_near)) return false;

  at.store_each([&](size_t r) { return to(r)->origin; });
  for (size_t r = 0; r < Axes::kRays; ++r) to(r)->reach = reach.of(r, 0);
  Axes slope = along, inverse, pad;
  set_slopes(to, slope, inverse, pad, reach);
  const Axes grown =
      share.mul_add(reach, around) * Axes::all(1 + 16 * kRoundoff) + Axes::all(kUnderflow);
  grown.mul_add(inverse.size(), pad).store_each([&](size_t r) { return to(r)->pad; });
  const Axes most = grown.greatest();
  const uint32_t is_main = (slope.size() == slope.size().greatest()).bits();
  for (size_t r = 0; r < Axes::kRays; ++r) {
    ObjectRay& inner = *to(r);
    const OneRay& outer = *ray(r);
    inner.set_main_axis(is_main >> 4 * r & 15);
    inner.off_ = most.of(r, 0);
    inner.near_limit = moved(outer.t_min * outer.scale * inner.scale, -2 * kTimeSlack);
    inner.shorten(outer);
  }
  return true;
}

// The rays of a packet, as one frustum in object space. Rays: FanRays or BundleRays.
class ObjectFrustum : public Frustum {
  using V = PacketRays::V;
  static constexpr size_t kLanes = PacketRays::kLanes;

 public:
  // Returns: whether the rays form a frustum in object space; if not, they have to be traced one by
  // one.
  template <class Rays>
  HWY_INLINE bool enter(const Rays& rays, const InstanceBlock& instance, const SceneBox& box);
  // To be called after hits: ends the frustum where no ray looks any further.
  template <class Rays>
  HWY_INLINE void shorten(const Rays& rays);

 private:
  HWY_INLINE void set_origin(const FanRays& rays, const InstanceBlock& instance);
  HWY_INLINE void set_origin(const BundleRays& rays, const InstanceBlock& instance);
  template <class Rays>
  HWY_INLINE bool set_slopes(const Rays& rays, const InstanceBlock& instance, float& ratio);
  HWY_INLINE void set_offsets(const FanRays&) {
    for (int k = 0; k < 2; ++k) offset_u[k] = offset_v[k] = 0;
  }
  HWY_INLINE void set_offsets(const BundleRays& rays);
  HWY_INLINE bool grow(const InstanceBlock& instance, const SceneBox& box, float ratio);
  // The component of the row's vectors along an axis of object space.
  static HWY_INLINE V along(const InstanceBlock& instance, int axis, V x, V y, V z) {
    const auto part = [&](int b) { return set<V>(instance.to_object[b][axis]); };
    return mul_add(part(0), x, mul_add(part(1), y, part(2) * z));
  }

  float origin_size_[3];  // the largest L of a ray
  float spread_ = 0;      // largest distance, by axis, of a ray's origin from the frustum's
  float margin_ = 0;      // what z_far grows by
  alignas(64) float speed_[kPacketRays];    // d' along the main axis
  alignas(64) float start_[kPacketRays];    // depth at which a ray begins
  alignas(64) float from_[2][kPacketRays];  // of a bundle: places of its rays across the main axis
};

template <class Rays>
bool ObjectFrustum::enter(const Rays& rays, const InstanceBlock& instance, const SceneBox& box) {
  // Any ray may choose the main axis, for those that are not valid go where the middle one goes.
  constexpr size_t kSome = 27;
  float size[3];
  for (size_t a = 0; a < 3; ++a) {
    const auto part = [&](int b) { return instance.to_object[b][a] * rays.direction[b][kSome]; };
    size[a] = part(0) + part(1) + part(2);
  }
  const int larger = abs_of(size[0]) >= abs_of(size[1]) ? 0 : 1;
  const int axis = abs_of(size[larger]) >= abs_of(size[2]) ? larger : 2;
  set_axis(axis, size[axis] < 0);
  float ratio = 0;
  if (!set_slopes(rays, instance, ratio)) return false;
  set_origin(rays, instance);
  set_offsets(rays);
  if (!grow(instance, box, ratio)) return false;
  shorten(rays);
  return true;
}

template <class Rays>
bool ObjectFrustum::set_slopes(const Rays& rays, const InstanceBlock& instance, float& ratio) {
  V low_u = set<V>(__builtin_inff()), low_v = low_u, high_u = -low_u, high_v = high_u;
  V longest = set<V>(0);
  auto is_near = longest == longest;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V x = load<V>(rays.direction[0] + at), y = load<V>(rays.direction[1] + at);
    const V z = load<V>(rays.direction[2] + at);
    const V speed = along(instance, kz, x, y, z) * side;
    const V per_depth = 1 / speed;
    const V u = along(instance, kx, x, y, z) * per_depth;
    const V v = along(instance, ky, x, y, z) * per_depth;
    const auto is_steep = [&](V slope) { return abs(slope) <= PacketRays::kSteepest; };
    is_near = is_near && (speed > 0 && (is_steep(u) && is_steep(v)));
    low_u = min(low_u, u);
    high_u = max(high_u, u);
    low_v = min(low_v, v);
    high_v = max(high_v, v);
    longest = max(longest, rays.length_at(at) * per_depth);
    store(speed, speed_ + at);
  }
  if (!is_all<V>(is_near)) return false;
  // The slopes are moved out by the roundings of the quotient (two) and of its product with a
  // depth.
  const auto outward = [](float bound, float sign) {
    return bound + sign * abs_of(bound) * (8 * kRoundoff);
  };
  slope_u[0] = outward(least_lane(low_u), -1);
  slope_u[1] = outward(greatest_lane(high_u), 1);
  slope_v[0] = outward(least_lane(low_v), -1);
  slope_v[1] = outward(greatest_lane(high_v), 1);
  ratio = greatest_lane(longest);
  return true;
}

void ObjectFrustum::set_origin(const FanRays& rays, const InstanceBlock& instance) {
  for (int a = 0; a < 3; ++a) {
    const auto part = [&](int b) {
      return instance.to_object[b][a] * (rays.origin[b] - instance.to_world[b][3]);
    };
    origin[a] = part(0) + part(1) + part(2);
    origin_size_[a] = abs_of(part(0)) + abs_of(part(1)) + abs_of(part(2));
  }
  spread_ = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) store(set<V>(0), start_ + at);
}

// The frustum begins where the ray does that begins first along the main axis.
void ObjectFrustum::set_origin(const BundleRays& rays, const InstanceBlock& instance) {
  V first = set<V>(__builtin_inff()), size[3] = {set<V>(0), set<V>(0), set<V>(0)};
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const auto moved = [&](int a) { return load<V>(rays.from[a] + at) - instance.to_world[a][3]; };
    const V x = moved(0), y = moved(1), z = moved(2);
    store(along(instance, kx, x, y, z), from_[0] + at);
    store(along(instance, ky, x, y, z), from_[1] + at);
    const V depth = along(instance, kz, x, y, z) * side;
    store(depth, start_ + at);
    first = min(first, depth);
    for (int a = 0; a < 3; ++a) {
      const auto part = [&](int b, V v) { return abs(instance.to_object[b][a] * v); };
      size[a] = max(size[a], part(0, x) + part(1, y) + part(2, z));
    }
  }
  const float begin = least_lane(first);
  origin[kx] = from_[0][0];
  origin[ky] = from_[1][0];
  origin[kz] = begin * side;
  V farthest = set<V>(0);
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V z = load<V>(start_ + at) - begin;
    const V x = load<V>(from_[0] + at) - origin[kx];
    const V y = load<V>(from_[1] + at) - origin[ky];
    store(z, start_ + at);
    store(x, from_[0] + at);
    store(y, from_[1] + at);
    farthest = max(farthest, max(z, max(abs(x), abs(y))));
  }
  spread_ = greatest_lane(farthest) * (1 + 2 * kRoundoff);
  for (int a = 0; a < 3; ++a) origin_size_[a] = greatest_lane(size[a]);
}

// The offsets are moved out by the roundings of origins, products and sums, as in
// BundleRays::set_offsets().
void ObjectFrustum::set_offsets(const BundleRays&) {
  const float slack = 16 * kRoundoff * spread_;
  const auto set_across = [&](const float* from, const float* slope, float* offset) {
    V low = set<V>(__builtin_inff()), high = -low;
    for (size_t at = 0; at < kPacketRays; at += kLanes) {
      const V x = load<V>(from + at), z = load<V>(start_ + at);
      low = min(low, neg_mul_add(set<V>(slope[0]), z, x));
      high = max(high, neg_mul_add(set<V>(slope[1]), z, x));
    }
    offset[0] = least_lane(low) - slack;
    offset[1] = greatest_lane(high) + slack;
  };
  set_across(from_[0], slope_u, offset_u);
  set_across(from_[1], slope_v, offset_v);
}

// Makes room for P on all sides of the frustum. The origin is moved back by 2 P along the main
// axis, which is at least P and at most 3 P with the rounding of that place: P is more than 6 u of
// it. So a depth is off by at most 4 P, P of the box's included.
bool ObjectFrustum::grow(const InstanceBlock& instance, const SceneBox& box, float ratio) {
  float reach = 0, pad[3];
  for (int a = 0; a < 3; ++a) {
    pad[a] = instance.pad[a] + kPlacedOriginError * origin_size_[a];
    const float far = max_of(abs_of(box.lower[a] - origin[a]), abs_of(box.upper[a] - origin[a]));
    reach = max_of(reach, far + 2 * pad[a]);
  }
  reach += 2 * spread_;
  float worst = 0;
  for (int a = 0; a < 3; ++a) {
    const auto number = [&](int b) { return abs_of(instance.to_object[b][a]); };
    const float largest = max_of(max_of(number(0), number(1)), number(2));
    const float share = kPlacedDirectionError * (largest * ratio);
    worst = max_of(worst, share);
    pad[a] = (pad[a] + share * reach) * (1 + 16 * kRoundoff) + kUnderflow;
  }
  if (!(worst <= kPlacedDirectionErrorMax && reach < 0x1p100f)) return false;
  const float back = pad[kz];
  origin[kz] -= side * (2 * back);
  const auto grow_by = [&](float* slope, float* offset, float across) {
    offset[0] -= across + abs_of(slope[0]) * (4 * back);
    offset[1] += across + abs_of(slope[1]) * (4 * back);
  };
  // The roundings of the sums above are less than the room that pad has.
  grow_by(slope_u, offset_u, pad[kx]);
  grow_by(slope_v, offset_v, pad[ky]);
  margin_ = 4 * back;
  return true;
}

template <class Rays>
void ObjectFrustum::shorten(const Rays& rays) {
  V far = set<V>(-__builtin_inff());
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    far = max(far, mul_add(load<V>(speed_ + at), rays.farthest(at), load<V>(start_ + at)));
  }
  z_far = greatest_lane(far) * (1 + 2 * kTimeSlack) + margin_;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
