// SPDX-License-Identifier: Apache-2.0
// 64 rays traced together: what they have hit so far, and what is the same whether they leave one
// point (fan_rays-inl.h) or not (bundle_rays-inl.h).
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_PACKET_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PACKET_RAYS_INL_H_
#undef TESSERA_CORE_PACKET_RAYS_INL_H_
#else
#define TESSERA_CORE_PACKET_RAYS_INL_H_
#endif

#include "slave/core/ray/frustum-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// How tracing rays together ended.
enum class Together { kDone, kNoFrustum, kDoesNotPay };

HWY_INLINE const FanEntry* entry_of(const Fan& rays) { return rays.entry; }
template <class Packet>
HWY_INLINE const FanEntry* entry_of(const Packet&) {
  return nullptr;
}

struct PacketRays : Frustum {
  using V = Floats;
  using VI = Ints;
  using D = TagOf<V>;
  using M = MaskOf<V>;
  static constexpr size_t kLanes = kLaneCount;
  static constexpr size_t kRows = kPacketRays / kLanes;  // a row: the rays of one register

  static constexpr float kSteepest = 2;  // |u|, |v| of a ray near the main axis
  // Beyond these limits of the sum of |direction| single rays take care of overflow
  // (OneRay::setup()).
  static constexpr float kShortest = 0x1p-58f, kLongest = 0x1p60f;

  // The sums of the sizes of three numbers of each ray of a row. Values: arrays, or pointers to
  // them.
  template <class Values>
  static HWY_INLINE V sizes(const Values& values, size_t at);
  // Returns: the number of a ray in the middle. Requires: valid != 0.
  static HWY_INLINE size_t middle_of(uint64_t valid) {
    return valid >> 27 & 1u ? 27 : static_cast<size_t>(__builtin_ctzll(valid));
  }
  // Sets the main axis by the direction of a ray.
  template <class Packet>
  HWY_INLINE void aim(const Packet& rays, size_t ray);
  // Whether rays are near the main axis, and neither short nor long. z: what they move along it per
  // t; u, v: what they move across it per depth; sum: the sums of the sizes of their directions.
  static HWY_INLINE M is_near(V z, V u, V v, V sum);

  // Whether a hit is nearer than what the ray has, or as near and of a lower number.
  HWY_INLINE bool is_better(size_t ray, float t, float t_min, int32_t primitive) const {
    const bool is_lower = best[ray] == -1 || primitive < best[ray];
    return t >= t_min && (t < best_t[ray] || (t == best_t[ray] && is_lower));
  }
  void write_to(const HitArrays& hits) const;
  uint64_t blocked() const;

  int count = 0;  // of valid rays
  // Work left before tracing together does not pay (PacketTracer), in tests of a row; a primitive
  // of a block that is tested by itself counts for two of them.
  int work_left = 0;
  alignas(64) float best_t[kPacketRays];  // t_max without a hit
  alignas(64) int32_t best[kPacketRays];  // -1 without a hit
};

template <class Values>
PacketRays::V PacketRays::sizes(const Values& values, size_t at) {
  const auto size = [&](int a) { return abs(load<V>(values[a] + at)); };
  return size(0) + size(1) + size(2);
}

template <class Packet>
void PacketRays::aim(const Packet& rays, size_t ray) {
  const auto size = [&](int a) { return abs_of(rays.direction[a][ray]); };
  const int larger = size(0) >= size(1) ? 0 : 1;
  const int axis = size(larger) >= size(2) ? larger : 2;
  set_axis(axis, rays.direction[axis][ray] < 0);
}

HWY_INLINE PacketRays::M PacketRays::is_near(V z, V u, V v, V sum) {
  const auto is_gentle = [&](V slope) { return abs(slope) <= kSteepest; };
  const M is_close = z > 0 && is_gentle(u) && is_gentle(v);
  return is_close && sum > kShortest && sum < kLongest;
}

HWY_INLINE void PacketRays::write_to(const HitArrays& hits) const {
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const auto primitive = load<VI>(best + at);
    store(zero_if(primitive == -1, load<V>(best_t + at)), hits.t + at);
    store(primitive, reinterpret_cast<int32_t*>(hits.primitive) + at);
  }
}

HWY_INLINE uint64_t PacketRays::blocked() const {
  uint64_t bits = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const auto is_hit = load<VI>(best + at) != -1;
    bits |= uint64_t{bits_of<VI>(is_hit)} << at;
  }
  return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
