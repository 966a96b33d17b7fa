// SPDX-License-Identifier: Apache-2.0
// A few triangles, each of which is looked at for a row of rays that have nothing in common.
//
// Method. With the corners B' and C' from the middle of the scene, O' the ray's origin from there
// and D its direction, the ray's volume with the edge is D.(B' x C') + (O' x D).(C' - B'): six
// fused operations with numbers that belong to the edge, or to the ray (Pluecker coordinates). A
// line passes through the triangle where the volumes of the three edges have one sign. t is N.(A' -
// O') / N.D.
//
// Bounds. Let R be the largest coordinate of a corner from the middle, s that of the origin, |D|
// the sum of the sizes of components, u a rounding. A volume is off by at most
//    7 u |D| R R           B' x C': corners are off by u R, products and their difference are
//                          rounded
//   20 u |D| R s           O' x D is off by 3 u of its terms, C' - B' by 4 u R
//    u |D| (12 R R + 24 R s)   six fused operations, none above 2 |D| R (R + 2 s)
// which is less than 48 u |D| R (R + s). With n the largest component of N, which is off by u n and
// by 2^-50 where its terms cancel, N.D is off by less than (4.5 u n + 2^-48) |D|, and N.(A' - O')
// by less than (17 u n + 2^-47) (R + s). What t is as reported is at most 4 u of it away from the
// quotient (plane-inl.h), and the quotient's own operations take as many.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_LIST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_LIST_INL_H_
#undef TESSERA_CORE_TRIANGLE_LIST_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_LIST_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3

class TriangleList {
  using V = Floats;
  using M = MaskOf<V>;

 public:
  static constexpr int kLanes = 16;
  // More of them cost more than finding one's way among them.
  static constexpr size_t kMost = 64;
  // Scenes and rays of other sizes are for others: no product under- or overflows here.
  static constexpr float kSmallest = 0x1p-30f, kLargest = 0x1p30f;

  // A row of rays, as the list sees them.
  struct Row {
    V origin[3], direction[3];  // as given
    V size;                     // sum of the sizes of the direction's components
    V t_min, t_max;
    V from[3], moment[3];  // origin from the middle; its cross product with the direction
    V tolerance;           // of volumes
    V reach;               // R + s
    // Rays that are valid, and those of them whose numbers are so large or small that the bounds do
    // not hold: they are not looked at.
    uint32_t valid, odd;
    M is_looked_at;
  };
  // What a row of rays sees of a triangle.
  struct Sight {
    M is_sure;     // the line passes through
    M is_certain;  // it does so within the ray's limits
    V low;         // where t is not below it; NaN where the ray surely does not meet the triangle
    V high;        // where t is not above it
  };

  void clear() { count_ = 0; }
  size_t count() const { return count_; }
  // Adds the triangles of a block. Returns: whether there was room.
  HWY_INLINE bool add(const TriangleBlock<kLanes>& block);
  // Must be called after the last add(). Returns: whether the triangles are of a size to look at.
  bool finish(const SceneBox& box);

  // Takes a row of the first packet.
  HWY_INLINE void set_row(const ManyRays& rays, size_t at, Row& row) const;
  HWY_INLINE Sight look(const Row& row, size_t triangle) const;

  int32_t number(size_t triangle) const { return number_[triangle]; }
  // Decides a triangle that is open. is_known: whether t is that of the plane; else it is found.
  // Shape: origin [3], direction [3].
  HWY_NOINLINE bool decide(size_t triangle, const float* origin, const float* direction,
                           bool is_known, float& t) const;
  // t of sixteen pairs of a ray of the row and a triangle, to the bit that of plane_t(). Returns:
  // bits of the pairs for which it counts.
  HWY_INLINE uint32_t times(const Row& row, Ints lane, Ints triangle, float* t) const;

 private:
  static constexpr size_t kRoom = kMost + size_t{kLanes};  // registers are stored whole

  void set_edges(size_t at, V& reach);
  void set_planes(size_t at);

  size_t count_ = 0;
  float middle_[3], reach_;
  alignas(64) float corner_[9][kRoom];
  alignas(64) int32_t number_[kRoom];
  alignas(64) float edge_[3][3][kRoom], moment_[3][3][kRoom];
  alignas(64) double normal_[3][kRoom], least_[kRoom];
  alignas(64) float slope_[3][kRoom], start_[kRoom];  // N and N.(A - middle), in float
  alignas(64) float speed_error_[kRoom], distance_error_[kRoom];
};

bool TriangleList::add(const TriangleBlock<kLanes>& block) {
  const auto number = load<Ints>(reinterpret_cast<const int32_t*>(block.primitive));
  const auto is_here = number != -1;
  const size_t count = count_of<Ints>(is_here);
  if (count_ + count > kMost) return false;
  for (size_t k = 0; k < 9; ++k)
    store_packed(load<V>(block.vertex[k]), is_here, corner_[k] + count_);
  store_packed(number, is_here, number_ + count_);
  count_ += count;
  return true;
}

inline bool TriangleList::decide(size_t triangle, const float* origin, const float* direction,
                                 bool is_known, float& t) const {
  TESSERA_COUNT(exact, 1);
  float corners[9];
  for (size_t k = 0; k < 9; ++k) corners[k] = corner_[k][triangle];
  if (is_known) return is_exact_hit(origin, direction, corners);
  const ExactHit exact = exact_hit(origin, direction, corners);
  t = exact.t;
  return exact.is_hit;
}

inline bool TriangleList::finish(const SceneBox& box) {
  for (size_t a = 0; a < 3; ++a) middle_[a] = 0.5f * (box.lower[a] + box.upper[a]);
  // What lies behind the last triangle is a copy of the first.
  for (auto& corner : corner_) store_unaligned(set<V>(corner[0]), corner + count_);
  V reach = set<V>(0);
  for (size_t at = 0; at < count_; at += kLaneCount) set_edges(at, reach);
  for (size_t at = 0; at < count_; at += kLanesOf<Doubles>) set_planes(at);
  reach_ = greatest_lane(reach);
  return is_all<V>(reach < kLargest) && reach_ > kSmallest;
}

inline void TriangleList::set_edges(size_t at, V& reach) {
  V corner[3][3];
  for (size_t c = 0; c < 3; ++c) {
    for (size_t a = 0; a < 3; ++a) {
      corner[c][a] = load<V>(corner_[3 * c + a] + at) - middle_[a];
      reach = max(abs(corner[c][a]), reach);
    }
  }
  for (size_t e = 0; e < 3; ++e) {
    const V *const p = corner[(e + 1) % 3], *const q = corner[(e + 2) % 3];
    for (size_t a = 0; a < 3; ++a) {
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      store(q[a] - p[a], edge_[e][a] + at);
      store(mul_sub(p[b], q[c], p[c] * q[b]), moment_[e][a] + at);
    }
  }
}

inline void TriangleList::set_planes(size_t at) {
  using VF = FloatOf<Doubles>;
  const auto plane = plane_terms<Doubles>(
      [&](size_t k) HWY_ATTR { return in_double(corner_[k] + at); },
      [&](size_t k) HWY_ATTR { return set<Doubles>(static_cast<double>(middle_[k])); });
  VF most = set<VF>(0);
  for (size_t a = 0; a < 3; ++a) {
    const VF slope = convert<VF>(plane.normal[a]);
    most = max(most, abs(slope));
    store(slope, slope_[a] + at);
    store(plane.normal[a], normal_[a] + at);
  }
  store(plane.least, least_ + at);
  store(convert<VF>(plane.distance), start_ + at);
  store(most * (4.5f * kRoundoff) + 0x1p-48f, speed_error_ + at);
  store(most * (17 * kRoundoff) + 0x1p-47f, distance_error_ + at);
}

// Validity is that of OneRay::setup().
void TriangleList::set_row(const ManyRays& rays, size_t at, Row& row) const {
  V far = set<V>(0), size = far;
  M is_finite = first_lanes<V>(kLaneCount);
  for (size_t a = 0; a < 3; ++a) {
    row.origin[a] = load<V>(rays.origin[a] + at);
    row.direction[a] = load<V>(rays.direction[a] + at);
    row.from[a] = row.origin[a] - middle_[a];
    far = max(abs(row.from[a]), far);
    size = size + abs(row.direction[a]);
    is_finite = is_finite && abs(row.origin[a]) < __builtin_inff();
  }
  for (size_t a = 0; a < 3; ++a) {
    const size_t b = (a + 1) % 3, c = (a + 2) % 3;
    row.moment[a] = mul_sub(row.from[b], row.direction[c], row.from[c] * row.direction[b]);
  }
  row.t_min = load<V>(rays.t_min + at);
  row.t_max = load<V>(rays.t_max + at);
  row.size = size;
  row.reach = far + reach_;
  row.tolerance = size * row.reach * (48 * kRoundoff * reach_);
  const M is_valid = is_finite && size > 0 && size < __builtin_inff() && row.t_min <= row.t_max;
  const M is_usual = size > kSmallest && size < kLargest && far < kLargest;
  row.valid = bits_of<V>(is_valid) & static_cast<uint32_t>(rays.active[0] >> at);
  row.odd = row.valid & ~bits_of<V>(is_usual);
  row.is_looked_at = mask_of<V>(row.valid & ~row.odd);
}

TriangleList::Sight TriangleList::look(const Row& row, size_t triangle) const {
  V volume[3];
  for (size_t e = 0; e < 3; ++e) {
    volume[e] = row.direction[0] * moment_[e][0][triangle];
    for (size_t a = 1; a < 3; ++a)
      volume[e] = mul_add(row.direction[a], set<V>(moment_[e][a][triangle]), volume[e]);
    for (size_t a = 0; a < 3; ++a)
      volume[e] = mul_add(row.moment[a], set<V>(edge_[e][a][triangle]), volume[e]);
  }
  const V least = min(min(volume[0], volume[1]), volume[2]);
  const V greatest = max(max(volume[0], volume[1]), volume[2]);
  const V depth = max(least, -greatest);  // how far inside, whichever side faces the ray
  V speed = row.direction[0] * slope_[0][triangle];
  V distance = neg_mul_add(row.from[0], set<V>(slope_[0][triangle]), set<V>(start_[triangle]));
  for (size_t a = 1; a < 3; ++a) {
    const V slope = set<V>(slope_[a][triangle]);
    speed = mul_add(row.direction[a], slope, speed);
    distance = neg_mul_add(row.from[a], slope, distance);
  }
  // With the least that N.D may be below the line, t is off by what the rest of it may be.
  const V off = row.size * speed_error_[triangle], slowest = abs(speed) - off;
  const V per_speed = 1 / slowest;
  const V size = abs(distance) * per_speed, t = copy_sign(size, hn::Xor(distance, speed));
  const V error = mul_add(row.reach, set<V>(distance_error_[triangle]), size * off * 2);
  const V half = mul_add(error * per_speed, set<V>(1 + 0x1p-20f), size * (16 * kRoundoff));
  const M is_clear = slowest > 0 && half < __builtin_inff();
  const V infinity = set<V>(__builtin_inff());
  const V low = select(is_clear, t - half, -infinity), high = select(is_clear, t + half, infinity);
  const M is_near = low <= row.t_max && high >= row.t_min;
  const M is_possible = and_not(depth < -row.tolerance, row.is_looked_at && is_near);
  const M is_sure = is_possible && depth > row.tolerance;
  const M is_certain = is_sure && low >= row.t_min && high <= row.t_max;
  return {is_sure, is_certain, select(is_possible, low, set<V>(__builtin_nanf(""))), high};
}

uint32_t TriangleList::times(const Row& row, Ints lane, Ints triangle, float* t) const {
  const TagOf<V> d;
  const TagOf<Doubles> dd;
  const auto index = hn::IndicesFromVec(d, lane);
  V direction[3], origin[3], corner[3];
  for (size_t a = 0; a < 3; ++a) {
    direction[a] = hn::TableLookupLanes(row.direction[a], index);
    origin[a] = hn::TableLookupLanes(row.origin[a], index);
    corner[a] = gather(corner_[a], triangle);
  }
  uint32_t clear = 0;
  FloatOf<Doubles> distance[2], speed[2], steepness[2];
  const auto half = [&]<bool kUpper>() HWY_ATTR {
    const auto part = [&](auto v) HWY_ATTR {
      const hn::Half<TagOf<decltype(v)>> lanes;
      if constexpr (kUpper) return hn::UpperHalf(lanes, v);
      if constexpr (!kUpper) return hn::LowerHalf(lanes, v);
    };
    const auto in_double = [&](V v) HWY_ATTR { return convert<Doubles>(part(v)); };
    const auto number = convert<hn::Vec<hn::Rebind<int64_t, TagOf<Doubles>>>>(part(triangle));
    Doubles normal[3], to[3], along[3];
    for (size_t a = 0; a < 3; ++a) {
      normal[a] = hn::GatherIndex(dd, normal_[a], number);
      to[a] = in_double(corner[a]) - in_double(origin[a]);
      along[a] = in_double(direction[a]);
    }
    const auto sum = [&](const Doubles* v) HWY_ATTR {
      return (v[0] * normal[0] + v[1] * normal[1]) + v[2] * normal[2];
    };
    const Doubles way = sum(to), least = hn::GatherIndex(dd, least_, number);
    const Doubles reach = abs(to[0]) + abs(to[1]) + abs(to[2]);
    clear |= bits_of<Doubles>(abs(way) >= least * reach) << (kUpper ? 8 : 0);
    distance[kUpper] = convert<FloatOf<Doubles>>(way);
    speed[kUpper] = convert<FloatOf<Doubles>>(sum(along));
    steepness[kUpper] = convert<FloatOf<Doubles>>(least);
  };
  half.template operator()<false>();
  half.template operator()<true>();
  const auto whole = [&](const FloatOf<Doubles>* v) HWY_ATTR { return hn::Combine(d, v[1], v[0]); };
  const V way = whole(distance), moved = whole(speed);
  const V size = (abs(direction[0]) + abs(direction[1])) + abs(direction[2]);
  const M is_good = abs(way) >= kPlaneLeast && abs(way) <= 1 / kPlaneLeast;
  const M counts = is_good && abs(moved) >= whole(steepness) * size + kPlaneLeast;
  store_unaligned(way / moved, t);
  return bits_of<V>(counts) & clear;
}

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
