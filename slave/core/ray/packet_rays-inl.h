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

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// How tracing rays together ended.
enum class Together { kDone, kNoFrustum, kDoesNotPay };

HWY_INLINE const FanEntry* entry_of(const FanPacket& rays) { return rays.entry; }
HWY_INLINE const FanEntry* entry_of(const RayPacket&) { return nullptr; }

struct PacketRays : Frustum {
  using D = hn::CappedTag<float, 16>;
  using DI = hn::CappedTag<int32_t, 16>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr size_t kLanes = hn::MaxLanes(D());
  static constexpr size_t kRows = kPacketRays / kLanes;  // a row: the rays of one register

  static constexpr float kSteepest = 2;  // |u|, |v| of a ray near the main axis

  // What a test knows of one primitive and a row of rays.
  struct RowTest {
    V t;
    M counts;       // t is the primitive's answer where the ray meets it
    M is_possible;  // not surely outside
    M is_sure;      // surely inside, and t counts
    V t_min;
  };

  // Takes the hits that are sure. Returns: the bits of the rays that exact_hit() has to decide.
  template <bool kAny>
  HWY_INLINE uint32_t take(size_t row, const RowTest& test, uint32_t primitive, bool& has_hit);
  // A hit of one ray, already decided. Returns: whether it is nearer than what the ray had.
  template <bool kAny>
  bool take(size_t ray, float t, float t_min, uint32_t primitive);

  // The sums of the sizes of three numbers of each ray of a row.
  static HWY_INLINE V sizes(const float (*values)[kPacketRays], size_t at);
  // Returns: the number of a ray in the middle. Requires: valid != 0.
  static HWY_INLINE size_t middle_of(uint64_t valid) {
    return valid >> 27 & 1u ? 27 : static_cast<size_t>(__builtin_ctzll(valid));
  }
  // Takes the main axis from a ray.
  template <class Packet>
  HWY_INLINE void aim(const Packet& rays, size_t ray);
  // The row's directions, lengths and limits; u, v: what it moves across the main axis per depth.
  // Rays that are not valid go where the middle one goes, and hit nothing. Returns: whether all are
  // near the main axis.
  template <class Packet>
  HWY_INLINE bool begin_row(const Packet& rays, size_t row, uint64_t valid, size_t middle, V& u,
                            V& v);

  HWY_INLINE V depths(size_t row) const;  // behind which no ray of the row looks
  HWY_INLINE void set_depths();           // before anything is hit
  HWY_INLINE void shorten(size_t row);    // after hits in a row
  HWY_INLINE void shorten();              // after those
  void store(PacketHits& hits) const;
  uint64_t blocked() const;

  int count = 0;  // of valid rays
  // In tests of a row; a primitive that is left of a block counts for two of them. See PacketTracer.
  int work_left = 0;
  alignas(64) float direction[3][kPacketRays];
  alignas(64) float length[kPacketRays];  // sum of |direction|
  alignas(64) float start[kPacketRays];   // depth at which the ray begins
  alignas(64) float best_t[kPacketRays];  // t_max without a hit
  alignas(64) int32_t best[kPacketRays];  // -1 without a hit
  alignas(64) float row_far[kRows];       // z_far of each row
};

HWY_INLINE PacketRays::V PacketRays::sizes(const float (*values)[kPacketRays], size_t at) {
  const D d;
  const auto size = [&](int a) { return hn::Abs(hn::Load(d, values[a] + at)); };
  return hn::Add(hn::Add(size(0), size(1)), size(2));
}

template <class Packet>
void PacketRays::aim(const Packet& rays, size_t ray) {
  const auto size = [&](int a) { return abs_of(rays.direction[a][ray]); };
  const int larger = size(0) >= size(1) ? 0 : 1;
  const int axis = size(larger) >= size(2) ? larger : 2;
  set_axis(axis, rays.direction[axis][ray] < 0);
}

template <class Packet>
bool PacketRays::begin_row(const Packet& rays, size_t row, uint64_t valid, size_t middle, V& u,
                           V& v) {
  const D d;
  const DI di;
  const size_t at = row * kLanes;
  const auto is_valid = mask_of(d, static_cast<uint32_t>(valid >> at));
  for (int a = 0; a < 3; ++a) {
    const V own = hn::Load(d, rays.direction[a] + at);
    hn::Store(hn::IfThenElse(is_valid, own, hn::Set(d, rays.direction[a][middle])), d,
              direction[a] + at);
  }
  const V sum = sizes(direction, at);
  const V t_max = hn::Load(d, rays.t_max + at);
  hn::Store(hn::IfThenElse(is_valid, t_max, hn::Neg(hn::Inf(d))), d, best_t + at);
  hn::Store(sum, d, length + at);
  hn::Store(hn::Set(di, -1), di, best + at);
  const V z = hn::Mul(hn::Load(d, direction[kz] + at), hn::Set(d, side));
  u = hn::Div(hn::Load(d, direction[kx] + at), z);
  v = hn::Div(hn::Load(d, direction[ky] + at), z);
  const auto is_steep = [&](V slope) { return hn::Le(hn::Abs(slope), hn::Set(d, kSteepest)); };
  auto is_near = hn::And(hn::Gt(z, hn::Zero(d)), hn::And(is_steep(u), is_steep(v)));
  // Beyond these limits single rays take care of overflow (OneRay::setup()).
  is_near = hn::And(is_near, hn::Gt(sum, hn::Set(d, 0x1p-58f)));
  is_near = hn::And(is_near, hn::Lt(sum, hn::Set(d, 0x1p60f)));
  return hn::AllTrue(d, is_near);
}

template <bool kAny>
uint32_t PacketRays::take(size_t row, const RowTest& test, uint32_t primitive, bool& has_hit) {
  const D d;
  const DI di;
  const size_t at = row * kLanes;
  const V old_t = hn::Load(d, best_t + at);
  const auto old = hn::Load(di, best + at);
  const auto number = hn::Set(di, static_cast<int32_t>(primitive));
  // -1, no hit yet, counts as the highest number.
  const M is_lower = hn::RebindMask(d, hn::Or(hn::Eq(old, hn::Set(di, -1)), hn::Lt(number, old)));
  const M is_nearer = hn::Or(hn::Lt(test.t, old_t), hn::And(hn::Eq(test.t, old_t), is_lower));
  const M in_range = hn::And(hn::Ge(test.t, test.t_min), is_nearer);
  const M hit = hn::And(test.is_sure, in_range);
  if (!hn::AllFalse(d, hit)) {
    has_hit = true;
    const V t = kAny ? hn::Set(d, -__builtin_inff()) : test.t;
    hn::Store(hn::IfThenElse(hit, t, old_t), d, best_t + at);
    hn::Store(hn::IfThenElse(hn::RebindMask(di, hit), number, old), di, best + at);
    shorten(row);
  }
  // Where t counts and is out of range, no decision about the edges matters.
  const M is_settled = hn::Or(test.is_sure, hn::AndNot(in_range, test.counts));
  return bits_of(d, hn::AndNot(is_settled, test.is_possible));
}

template <bool kAny>
bool PacketRays::take(size_t ray, float t, float t_min, uint32_t primitive) {
  const auto number = static_cast<int32_t>(primitive);
  const bool is_lower = best[ray] == -1 || number < best[ray];
  if (!(t >= t_min && (t < best_t[ray] || (t == best_t[ray] && is_lower)))) return false;
  best_t[ray] = kAny ? -__builtin_inff() : t;
  best[ray] = number;
  shorten(ray / kLanes);
  return true;
}

HWY_INLINE PacketRays::V PacketRays::depths(size_t row) const {
  const D d;
  const size_t at = row * kLanes;
  const V z = hn::Abs(hn::Load(d, direction[kz] + at));
  return hn::MulAdd(z, hn::Load(d, best_t + at), hn::Load(d, start + at));
}

HWY_INLINE void PacketRays::shorten(size_t row) {
  row_far[row] = hn::GetLane(hn::MaxOfLanes(D(), depths(row))) * (1 + kTimeSlack);
}

HWY_INLINE void PacketRays::set_depths() {
  const D d;
  const auto greatest = [](auto a, auto b) { return hn::Max(a, b); };
  const auto moved = [&](size_t row) { return hn::Mul(depths(row), hn::Set(d, 1 + kTimeSlack)); };
  fold_rows<kRows>(d, moved, greatest, row_far);
  shorten();
}

HWY_INLINE void PacketRays::shorten() {
  const hn::CappedTag<float, kRows> d;
  auto far = hn::Load(d, row_far);
  for (size_t at = hn::MaxLanes(d); at < kRows; at += hn::MaxLanes(d)) {
    far = hn::Max(far, hn::Load(d, row_far + at));
  }
  z_far = hn::GetLane(hn::MaxOfLanes(d, far));
}

inline void PacketRays::store(PacketHits& hits) const {
  const D d;
  const DI di;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const auto primitive = hn::Load(di, best + at);
    const auto is_miss = hn::RebindMask(d, hn::Eq(primitive, hn::Set(di, -1)));
    hn::Store(hn::IfThenElse(is_miss, hn::Zero(d), hn::Load(d, best_t + at)), d, hits.t + at);
    hn::Store(primitive, di, reinterpret_cast<int32_t*>(hits.primitive) + at);
  }
}

inline uint64_t PacketRays::blocked() const {
  uint64_t bits = 0;
  for (size_t i = 0; i < kPacketRays; ++i) bits |= uint64_t{best[i] != -1} << i;
  return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
