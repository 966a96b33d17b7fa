// SPDX-License-Identifier: Apache-2.0
// 64 rays that go about the same way from about the same place, seen as one frustum.
//
// With the main axis z and the direction scaled to z = 1, a ray is (x, y, z) = (ox, oy, oz) + (u,
// v, 1) (z - oz), so for z >= oz it lies on the inner side of x <= u_max z + max(ox - u_max oz),
// and of three more planes like it.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_BUNDLE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BUNDLE_RAYS_INL_H_
#undef TESSERA_CORE_BUNDLE_RAYS_INL_H_
#else
#define TESSERA_CORE_BUNDLE_RAYS_INL_H_
#endif

#include "slave/core/ray/packet_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct BundleRays : PacketRays {
  // A bundle that takes more steps than this is given up, and its rays are traced one by one from
  // the start; the steps are some per cent of what that takes.
  static constexpr int kStepsMax = 48;
  static constexpr int kKdStepsMax = 400;
  static constexpr int kRaysLeast = 12;    // fewer, or one lane, are faster alone
  static constexpr float kWidest = 0.75f;  // limit of u_max - u_min, v_max - v_min, likewise

  // Takes the first packet. Returns: whether its rays form a narrow frustum: those that are valid
  // go to one side of the main axis and to about the same part of it.
  bool setup(const ManyRays& rays);
  void line_up() {}  // as FanRays::line_up(): they are in line
  HWY_INLINE V length_at(size_t at) const { return load<V>(length + at); }
  HWY_INLINE void direction_of(size_t ray, float* to) const {
    for (int a = 0; a < 3; ++a) to[a] = direction[a][ray];
  }
  // Bits of those of the rays that are known not to meet the primitive.
  HWY_INLINE uint64_t excluding(uint64_t rays, int32_t primitive) const {
    uint64_t found = 0;
    if (excluded == nullptr) return found;
    for (; rays != 0; rays &= rays - 1) {
      const auto ray = static_cast<size_t>(__builtin_ctzll(rays));
      found |= uint64_t{static_cast<int32_t>(excluded[ray]) == primitive} << ray;
    }
    return found;
  }
  // Result of the test of one primitive against a row of rays.
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
  // Takes a hit of one ray, already decided. Returns: whether it is nearer than what the ray had.
  template <bool kAny>
  bool take(size_t ray, float t, float t_min, uint32_t primitive);

  HWY_INLINE V depths(size_t row) const;  // z of best_t of the row's rays
  HWY_INLINE void set_depths();           // to be called before anything is hit
  HWY_INLINE void shorten(size_t row);    // to be called after hits in a row
  HWY_INLINE void shorten();              // to be called after those
  // Upper bounds of the best t of the rays from `at` on.
  HWY_INLINE V farthest(size_t at) const { return load<V>(best_t + at); }

  alignas(64) float direction[3][kPacketRays];
  alignas(64) float length[kPacketRays];  // sum of |direction|
  alignas(64) float start[kPacketRays];   // depth at which the ray begins
  alignas(64) float row_far[kRows];       // z_far of each row
  const uint32_t* excluded = nullptr;     // ManyRays::excluded
  float reach = 0;  // largest distance, by axis, of a ray's origin from the frustum's
  alignas(64) float from[3][kPacketRays];                        // origins
  alignas(64) float shear_x[kPacketRays], shear_y[kPacketRays];  // dx / dz, dy / dz
  alignas(64) float t_min[kPacketRays];
  // Planes of each row, as those of the frustum.
  struct RowPlanes {
    alignas(64) float slope[2][kRows], offset[2][kRows];
  };
  RowPlanes row_u, row_v;

 private:
  static uint64_t valid_rays(const ManyRays& rays);
  bool setup_row(const ManyRays& rays, size_t row, uint64_t valid, size_t middle);
  void set_slopes(size_t row, V u, RowPlanes& planes);
  void set_offsets(int axis, RowPlanes& planes, const float* slope, float* offset);
  void set_origin(size_t middle);
};

inline uint64_t BundleRays::valid_rays(const ManyRays& rays) {
  uint64_t valid = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V sum = sizes(rays.direction, at), place = sizes(rays.origin, at);
    auto is_valid = sum > 0 && sum < __builtin_inff();
    is_valid = is_valid && place < __builtin_inff();
    is_valid = is_valid && load<V>(rays.t_max + at) >= load<V>(rays.t_min + at);
    valid |= uint64_t{bits_of<V>(is_valid)} << at;
  }
  return valid & rays.active[0];
}

inline bool BundleRays::setup(const ManyRays& rays) {
  const uint64_t valid = valid_rays(rays);
  if (kLanes == 1 || __builtin_popcountll(valid) < kRaysLeast) return false;
  const size_t middle = middle_of(valid);
  count = __builtin_popcountll(valid);
  excluded = rays.excluded;
  aim(rays, middle);
  for (size_t r = 0; r < kRows; ++r) {
    if (!setup_row(rays, r, valid, middle)) return false;
  }
  const auto widest = [](const RowPlanes& planes, float* slope) {
    slope[0] = planes.slope[0][0];
    slope[1] = planes.slope[1][0];
    for (size_t r = 1; r < kRows; ++r) {
      slope[0] = min_of(slope[0], planes.slope[0][r]);
      slope[1] = max_of(slope[1], planes.slope[1][r]);
    }
    return slope[1] - slope[0] <= kWidest;
  };
  if (!widest(row_u, slope_u) || !widest(row_v, slope_v)) return false;
  set_origin(middle);
  set_offsets(kx, row_u, slope_u, offset_u);
  set_offsets(ky, row_v, slope_v, offset_v);
  set_depths();
  return true;
}

// Returns: whether the rays of the row are near the main axis.
inline bool BundleRays::setup_row(const ManyRays& rays, size_t row, uint64_t valid, size_t middle) {
  const size_t at = row * kLanes;
  const auto is_valid = mask_of<V>(static_cast<uint32_t>(valid >> at));
  const auto copy = [&](const float* values, float* to) {
    const V used = select(is_valid, load<V>(values + at), set<V>(values[middle]));
    store(used, to + at);
    return used;
  };
  for (int a = 0; a < 3; ++a) copy(rays.direction[a], direction[a]);
  const V sum = sizes(direction, at), z = load<V>(direction[kz] + at) * side;
  const V t_max = load<V>(rays.t_max + at);
  store(select(is_valid, t_max, set<V>(-__builtin_inff())), best_t + at);
  store(sum, length + at);
  store(set<VI>(-1), best + at);
  const V u = load<V>(direction[kx] + at) / z, v = load<V>(direction[ky] + at) / z;
  if (!is_all<V>(is_near(z, u, v, sum))) return false;
  for (int a = 0; a < 3; ++a) copy(rays.origin[a], from[a]);
  if (!is_all<V>(copy(rays.t_min, t_min) >= 0)) return false;
  const V s = set<V>(side);
  store(u * s, shear_x + at);
  store(v * s, shear_y + at);
  set_slopes(row, u, row_u);
  set_slopes(row, v, row_v);
  return true;
}

// Slopes are moved out by the roundings of u itself and of its product with z.
inline void BundleRays::set_slopes(size_t row, V u, RowPlanes& planes) {
  const float low = least_lane(u), high = greatest_lane(u);
  planes.slope[0][row] = low - abs_of(low) * (8 * kRoundoff);
  planes.slope[1][row] = high + abs_of(high) * (8 * kRoundoff);
}

// The origin is the middle ray's across the main axis; along the axis no ray begins before it.
inline void BundleRays::set_origin(size_t middle) {
  const V s = set<V>(side);
  V least = set<V>(__builtin_inff());
  for (size_t at = 0; at < kPacketRays; at += kLanes)
    least = min(least, load<V>(from[kz] + at) * s);
  origin[kx] = from[kx][middle];
  origin[ky] = from[ky][middle];
  origin[kz] = least_lane(least) * side;
  V farthest = set<V>(0);
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V z = (load<V>(from[kz] + at) - origin[kz]) * s;
    store(z, start + at);
    const V x = load<V>(from[kx] + at) - origin[kx];
    const V y = load<V>(from[ky] + at) - origin[ky];
    farthest = max(farthest, max(z, max(abs(x), abs(y))));
  }
  reach = greatest_lane(farthest) * (1 + 2 * kRoundoff);
}

// Sets the offsets of all rows and of the whole bundle. They are moved out by the roundings of
// origins, products and sums: some 4 u of the origins' distance and 2 u of what a slope of at most
// 2 makes of it.
inline void BundleRays::set_offsets(int axis, RowPlanes& planes, const float* slope,
                                    float* offset) {
  const float slack = 16 * kRoundoff * reach;
  V all_low = set<V>(__builtin_inff()), all_high = -all_low;
  for (size_t r = 0; r < kRows; ++r) {
    const size_t at = r * kLanes;
    const V x = load<V>(from[axis] + at) - origin[axis];
    const V z = load<V>(start + at);
    const auto at_zero = [&](float k) { return neg_mul_add(set<V>(k), z, x); };
    planes.offset[0][r] = least_lane(at_zero(planes.slope[0][r])) - slack;
    planes.offset[1][r] = greatest_lane(at_zero(planes.slope[1][r])) + slack;
    all_low = min(all_low, at_zero(slope[0]));
    all_high = max(all_high, at_zero(slope[1]));
  }
  offset[0] = least_lane(all_low) - slack;
  offset[1] = greatest_lane(all_high) + slack;
}

template <bool kAny>
uint32_t BundleRays::take(size_t row, const RowTest& test, uint32_t primitive, bool& has_hit) {
  const size_t at = row * kLanes;
  const V old_t = load<V>(best_t + at);
  const auto old = load<VI>(best + at);
  const auto number = set<VI>(static_cast<int32_t>(primitive));
  // -1, no hit yet, counts as the highest number.
  const M is_lower = mask_as<V>(old == -1 || number < old);
  const M is_nearer = test.t < old_t || (test.t == old_t && is_lower);
  const M in_range = test.t >= test.t_min && is_nearer;
  const M hit = test.is_sure && in_range;
  if (!is_none<V>(hit)) {
    has_hit = true;
    const V t = kAny ? set<V>(-__builtin_inff()) : test.t;
    store(select(hit, t, old_t), best_t + at);
    store(select(hit, number, old), best + at);
    shorten(row);
  }
  // Where t counts and is out of range, no decision about the edges matters.
  const M is_settled = test.is_sure || and_not(in_range, test.counts);
  return bits_of<V>(and_not(is_settled, test.is_possible));
}

template <bool kAny>
bool BundleRays::take(size_t ray, float t, float t_min, uint32_t primitive) {
  const auto number = static_cast<int32_t>(primitive);
  if (!is_better(ray, t, t_min, number)) return false;
  best_t[ray] = kAny ? -__builtin_inff() : t;
  best[ray] = number;
  shorten(ray / kLanes);
  return true;
}

HWY_INLINE BundleRays::V BundleRays::depths(size_t row) const {
  const size_t at = row * kLanes;
  const V z = abs(load<V>(direction[kz] + at));
  return mul_add(z, load<V>(best_t + at), load<V>(start + at));
}

HWY_INLINE void BundleRays::shorten(size_t row) {
  row_far[row] = greatest_lane(depths(row)) * (1 + kTimeSlack);
}

HWY_INLINE void BundleRays::set_depths() {
  const auto greatest = [](auto a, auto b) { return max(a, b); };
  const auto moved = [&](size_t row) { return depths(row) * (1 + kTimeSlack); };
  fold_rows<kRows>(D(), moved, greatest, row_far);
  shorten();
}

HWY_INLINE void BundleRays::shorten() {
  using VR = FloatsOf<kRows>;
  VR far = load<VR>(row_far);
  for (size_t at = kLanesOf<VR>; at < kRows; at += kLanesOf<VR>)
    far = max(far, load<VR>(row_far + at));
  z_far = greatest_lane(far);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
