// SPDX-License-Identifier: Apache-2.0
// 64 rays that leave one point, seen as one frustum.
//
// The main axis z is where the rays go; the origin is moved to 0 and every direction scaled to
// z = 1, so a ray is (u, v, 1) and the packet lies in [u_min, u_max] x [v_min, v_max].
//
// The best hit of a ray is known by its nearness 1/z, which is linear in u and v over a plane. It
// is kept as an interval that holds the nearness of t as it will be reported. Planar primitives
// compare intervals; t is computed for the nearest in the end (`pending`) or where they overlap.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_FAN_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_RAYS_INL_H_
#undef TESSERA_CORE_FAN_RAYS_INL_H_
#else
#define TESSERA_CORE_FAN_RAYS_INL_H_
#endif

#include "slave/core/ray/packet_rays-inl.h"
#include "slave/core/ray/shadow_fan-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct FanRays : PacketRays {
  // A fan that gets through setup() is traced as one, however many steps it takes.
  static constexpr int kStepsMax = 0x7fffffff, kKdStepsMax = 0x7fffffff;
  // With few wide rows all rays are tested; with many rows, those that a primitive may touch.
  static constexpr bool kCullsRows = kRows > 4;
  // Where registers are narrow, what is done for each row weighs more.
  static constexpr bool kHasManyRows = kRows > 8;
  static constexpr size_t kFans = 1;  // see twin_rays-inl.h

  static constexpr int kRaysLeast = 4;  // fewer are faster alone

  // Returns: whether the rays form a frustum: those that are valid go to one side of the main axis
  // and not far from it.
  bool setup(const Fan& rays);
  // As above. The fan may be asked for any hits alone.
  bool setup(const ShadowFan& fan);
  // Makes registers of directions loadable from `direction` and length_at(), and lets rays that are
  // not valid go where one does that is. Fans of packets have the first from the start, for rays
  // that are valid.
  void line_up();
  HWY_INLINE FanRays& fan(size_t) { return *this; }

  // Takes a hit of one ray, already decided. Returns: whether it is nearer than what the ray had.
  // Requires: the ray's best hit is not pending.
  template <bool kAny>
  bool take(size_t ray, float t, float t_min, uint32_t primitive);
  // Sets the t of a ray's best hit, which was pending or is new.
  HWY_INLINE void settle(size_t ray, float t);
  // Both for some rays of the row that begins at `at`. Requires: directions lie there by ray.
  HWY_INLINE bool take_rays(size_t at, M rays, V t, int32_t primitive);
  HWY_INLINE void settle_rays(size_t at, M rays, V t);
  // Finds z_far and row_low; must be called after hits.
  HWY_INLINE void shorten();
  // Bounds the rays that still look for something; kAll: all of them do.
  template <bool kAll = false>
  HWY_INLINE void narrow();
  // Upper bounds of the best t of the rays from `at` on.
  HWY_INLINE V farthest(size_t at) const;
  HWY_INLINE void direction_of(size_t ray, float* to) const {
    for (int a = 0; a < 3; ++a) to[a] = direction[a][number_of(ray)];
  }
  HWY_INLINE size_t number_of(size_t ray) const {
    return numbers == nullptr ? ray : static_cast<size_t>(numbers[ray]);
  }
  // Bits of those of the rays that are known not to meet the primitive.
  HWY_INLINE uint64_t excluding(uint64_t rays, int32_t primitive) const {
    return excluded == primitive ? rays : ending_at(rays, primitive);
  }
  // The same of the primitives that they end next to.
  HWY_INLINE uint64_t ending_at(uint64_t rays, int32_t primitive) const {
    uint64_t found = 0;
    if (excluded_at_end == nullptr) return found;
    for (; rays != 0; rays &= rays - 1) {
      const auto ray = static_cast<size_t>(__builtin_ctzll(rays));
      const uint32_t at_end = excluded_at_end[number_of(ray)];
      found |= uint64_t{static_cast<int32_t>(at_end) == primitive} << ray;
    }
    return found;
  }
  // The sums of the sizes of the components of directions; of a row, and of one.
  HWY_INLINE V length_at(size_t at) const { return sizes(direction, at); }
  static HWY_INLINE float length_of(const float* d) {
    return abs_of(d[0]) + abs_of(d[1]) + abs_of(d[2]);
  }

  // Components of directions, by axis, in the caller's memory or `own`; by ray, or by its number
  // where there are numbers.
  const float* direction[3];
  const int* numbers = nullptr;
  uint64_t valid = 0;  // rays that may hit something
  Diagonals diagonals;
  size_t filled_rows = kRows;  // rows with rays that are valid, from the first
  float t_min = 0;
  int32_t excluded = -1;                      // ShadowFans::excluded_at_origin
  const uint32_t* excluded_at_end = nullptr;  // see ShadowFans; null: nothing is known
  float steepness = 0;                        // largest sum of the sizes of u, v and 1 of a ray
  float widest[2];                            // largest size of u, of v
  float nearest_min;  // a hit of less nearness is certainly not before t_min
  alignas(64) float ray_u[kPacketRays], ray_v[kPacketRays];
  alignas(64) float row_u[2][kRows], row_v[2][kRows];
  // Interval of the nearness of the best hit, or of t_max. Infinite for rays that look for nothing.
  alignas(64) float low[kPacketRays], high[kPacketRays];
  alignas(64) float row_low[kRows];  // least `low` of each row, where there are more than 4 rows
  // Where t of the best hit is not known yet: a number by which the primitives' test knows what was
  // hit. Else -1.
  alignas(64) int32_t pending[kPacketRays];

 private:
  // Relative error of a nearness computed from t is less than this: 4 roundings of t itself, and
  // one each of its product with z, of the quotient and of the bound.
  static constexpr float kNearSlack = 8 * kRoundoff;
  // More than any slope, of which bounds can be computed.
  static constexpr float kBeyond = 0x1p60f;
  // Greatest `low`, for hits at t = 0, beside which there may be others at 0.
  static constexpr float kNearMax = 0x1.fffffep127f;

  // Returns: whether rays that begin there may be traced together.
  bool set_start(const float* from, float least);
  // Sets each row by set_row(), which says whether its rays are near the main axis, then what
  // follows from all of them. Returns: whether all are.
  template <class Row>
  bool set_rows(const Row& set_row);
  static uint64_t valid_rays(const Fan& rays);
  bool setup_row(const Fan& rays, size_t row, size_t middle);
  bool setup_row(const ShadowFan& fan, size_t row);
  void limit_row(size_t row, M is_valid, V per_depth, V t_max, bool is_endless);
  void bound();

  V least_per_depth_;  // over valid rays, in each lane
  alignas(64) float own_[3][kPacketRays];
  uint32_t own_excluded_[kPacketRays];  // of valid rays
};

HWY_INLINE uint64_t FanRays::valid_rays(const Fan& rays) {
  uint64_t valid = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V sum = sizes(rays.direction, at);
    const M is_valid = sum > 0 && sum < __builtin_inff() && load<V>(rays.t_max + at) >= rays.t_min;
    valid |= uint64_t{bits_of<V>(is_valid)} << at;
  }
  return valid & rays.active;
}

HWY_INLINE bool FanRays::setup(const Fan& rays) {
  if (!set_start(rays.origin, rays.t_min)) return false;
  valid = valid_rays(rays);
  if (__builtin_popcountll(valid) < kRaysLeast) return false;
  const size_t middle = middle_of(valid);
  filled_rows = (64 - static_cast<size_t>(__builtin_clzll(valid)) + kLanes - 1) / kLanes;
  count = __builtin_popcountll(valid);
  for (int a = 0; a < 3; ++a) direction[a] = rays.direction[a];
  if (rays.entry != nullptr) {
    set_axis(rays.entry->axis, rays.entry->side < 0);
  } else {
    aim(rays, middle);
  }
  return set_rows([&](size_t row) HWY_ATTR { return setup_row(rays, row, middle); });
}

HWY_INLINE bool FanRays::set_start(const float* from, float least) {
  for (int a = 0; a < 3; ++a) origin[a] = from[a];
  t_min = least;
  return length_of(from) < __builtin_inff() && least >= 0;
}

template <class Row>
HWY_INLINE bool FanRays::set_rows(const Row& set_row) {
  least_per_depth_ = set<V>(__builtin_inff());
  for (size_t row = 0; row < kRows; ++row) {
    if (!set_row(row)) return false;
  }
  bound();
  shorten();
  return true;
}

// Returns: whether the rays of the row are near the main axis.
HWY_INLINE bool FanRays::setup_row(const Fan& rays, size_t row, size_t middle) {
  const size_t at = row * kLanes;
  const M is_valid = mask_of<V>(static_cast<uint32_t>(valid >> at));
  const auto along = [&](int axis) HWY_ATTR {
    return select(is_valid, load<V>(direction[axis] + at), set<V>(direction[axis][middle]));
  };
  const V x = along(kx), y = along(ky), z = along(kz) * side, per_depth = 1 / z;
  const V u = x * per_depth, v = y * per_depth;
  if (!is_all<V>(is_near(z, u, v, abs(x) + abs(y) + abs(z)))) return false;
  store(u, ray_u + at);
  store(v, ray_v + at);
  store(set<VI>(-1), pending + at);
  const V t_max = load<V>(rays.t_max + at);
  // A division for each of many rows is saved, mostly; few rows are done before that is known.
  const bool is_endless = kHasManyRows && is_none<V>(is_valid && t_max < __builtin_inff());
  limit_row(row, is_valid, per_depth, t_max, is_endless);
  return true;
}

// is_endless: t_max of all valid rays is known to be infinite.
HWY_INLINE void FanRays::limit_row(size_t row, M is_valid, V per_depth, V t_max, bool is_endless) {
  const size_t at = row * kLanes;
  const V infinity = set<V>(__builtin_inff());
  least_per_depth_ = min(least_per_depth_, select(is_valid, per_depth, infinity));
  const V near = is_endless ? set<V>(0) : per_depth / abs(t_max);  // -0 is 0
  const V least = min(near * (1 - kNearSlack) - kUnderflow, kNearMax);
  store(select(is_valid, least, infinity), low + at);
  store(select(is_valid, near * (1 + kNearSlack) + kUnderflow, infinity), high + at);
  store(select(is_valid, t_max, -infinity), best_t + at);
  store(set<VI>(-1), best + at);
}

HWY_INLINE bool FanRays::setup(const ShadowFan& fan) {
  const ShadowFans& all = fan.fans;
  const FanTargets& targets = *all.targets;
  if (!set_start(all.origin, all.t_min)) return false;
  if (fan.count < kRaysLeast || !(all.t_max >= all.t_min)) return false;
  set_axis(fan.face / 2, fan.face % 2 != 0);
  count = static_cast<int>(fan.count);
  valid = fan.active;
  numbers = targets.order + fan.first;
  for (int a = 0; a < 3; ++a) direction[a] = targets.direction[a];
  excluded = static_cast<int32_t>(all.excluded_at_origin);
  excluded_at_end = all.excluded_at_end;
  filled_rows = (fan.count + kLanes - 1) / kLanes;
  return set_rows([&](size_t row) HWY_ATTR { return setup_row(fan, row); });
}

// Where a ray is no ray of a fan, all of them are traced alone.
HWY_INLINE bool FanRays::setup_row(const ShadowFan& fan, size_t row) {
  const size_t at = row * kLanes;
  const auto& projected = fan.fans.targets->projected;
  const float *const us = projected[0] + fan.first, *const vs = projected[1] + fan.first;
  const M is_valid = first_lanes<V>(at >= fan.count ? 0 : min_of(fan.count - at, kLanes));
  const V u = select(is_valid, load_unaligned<V>(us + at), set<V>(us[0]));
  const V v = select(is_valid, load_unaligned<V>(vs + at), set<V>(vs[0]));
  const V per_depth = load_unaligned<V>(projected[2] + fan.first + at);
  // The sum of the sizes of a direction is at least its depth, and at most three times that.
  const M is_within =
      abs(u) <= 1 && abs(v) <= 1 && per_depth < 1 / kShortest && per_depth > 3 / kLongest;
  if (!is_none<V>(and_not(is_within, is_valid))) return false;
  store(u, ray_u + at);
  store(v, ray_v + at);
  limit_row(row, is_valid, per_depth, set<V>(fan.fans.t_max), false);
  return true;
}

inline void FanRays::line_up() {
  const auto middle = static_cast<size_t>(__builtin_ctzll(valid));
  for (size_t ray = 0; ray < kPacketRays; ++ray) {
    float d[3];
    direction_of((valid >> ray & 1u) != 0 ? ray : middle, d);
    for (int a = 0; a < 3; ++a) own_[a][ray] = d[a];
    if (excluded_at_end != nullptr && (valid >> ray & 1u) != 0)
      own_excluded_[ray] = excluded_at_end[number_of(ray)];
  }
  if (excluded_at_end != nullptr) excluded_at_end = own_excluded_;
  for (int a = 0; a < 3; ++a) direction[a] = own_[a];
  numbers = nullptr;
}

HWY_INLINE void FanRays::bound() {
  if constexpr (kCullsRows) {
    const auto least = [](auto a, auto b) { return min(a, b); };
    const auto greatest = [](auto a, auto b) { return max(a, b); };
    const auto u = [&](size_t row) { return load<V>(ray_u + row * kLanes); };
    const auto v = [&](size_t row) { return load<V>(ray_v + row * kLanes); };
    fold_rows<kRows>(D(), u, least, row_u[0]);
    fold_rows<kRows>(D(), u, greatest, row_u[1]);
    fold_rows<kRows>(D(), v, least, row_v[0]);
    fold_rows<kRows>(D(), v, greatest, row_v[1]);
  }
  narrow<kHasManyRows>();  // rays that are not valid go where one does that is
  widest[0] = max_of(-slope_u[0], slope_u[1]);
  widest[1] = max_of(-slope_v[0], slope_v[1]);
  steepness = 1 + widest[0] + widest[1];
  nearest_min = __builtin_inff();
  if (!(t_min > 0)) return;
  nearest_min = least_lane(least_per_depth_) / t_min * (1 - kNearSlack) - kUnderflow;
}

template <bool kAll>
HWY_INLINE void FanRays::narrow() {
  V least[4], most[4];
  for (size_t k = 0; k < 4; ++k) {
    least[k] = set<V>(kBeyond);
    most[k] = set<V>(-kBeyond);
  }
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const M looks = load<V>(low + at) < __builtin_inff();
    const V u = load<V>(ray_u + at), v = load<V>(ray_v + at);
    const V all[4] = {u, v, u + v, u - v};
    for (size_t k = 0; k < 4; ++k) {
      const V low_of = min(least[k], all[k]), high_of = max(most[k], all[k]);
      least[k] = kAll ? low_of : select(looks, low_of, least[k]);
      most[k] = kAll ? high_of : select(looks, high_of, most[k]);
    }
  }
  alignas(16) float from[4], to[4];
  fold_rows<4>(
      D(), [&](size_t k) { return least[k]; }, [](auto a, auto b) { return min(a, b); }, from);
  fold_rows<4>(
      D(), [&](size_t k) { return most[k]; }, [](auto a, auto b) { return max(a, b); }, to);
  // Each bound is moved out by the roundings of u itself and of its product with z.
  const auto outward = [](float bound, float sign) {
    return bound + sign * abs_of(bound) * (8 * kRoundoff);
  };
  slope_u[0] = outward(from[0], -1);
  slope_u[1] = outward(to[0], 1);
  slope_v[0] = outward(from[1], -1);
  slope_v[1] = outward(to[1], 1);
  // A sum has a rounding more, and may be smaller than what it is the sum of.
  const float slack = 8 * kRoundoff * (max_of(-from[0], to[0]) + max_of(-from[1], to[1]));
  diagonals = {{from[2] - slack, to[2] + slack}, {from[3] - slack, to[3] + slack}};
}

template <bool kAny>
HWY_INLINE bool FanRays::take(size_t ray, float t, float least, uint32_t primitive) {
  const auto number = static_cast<int32_t>(primitive);
  if (!is_better(ray, t, least, number)) return false;
  best[ray] = number;
  if (kAny) {
    best_t[ray] = -__builtin_inff();
    low[ray] = high[ray] = __builtin_inff();
  } else {
    settle(ray, t);
  }
  return true;
}

HWY_INLINE void FanRays::settle(size_t ray, float t) {
  best_t[ray] = t;
  pending[ray] = -1;
  const float near = 1 / abs_of(direction[kz][ray] * t);  // t may be -0
  low[ray] = min_of(near * (1 - kNearSlack) - kUnderflow, kNearMax);
  high[ray] = near * (1 + kNearSlack) + kUnderflow;
}

HWY_INLINE bool FanRays::take_rays(size_t at, M rays, V t, int32_t primitive) {
  const VI now = load<VI>(best + at), number = set<VI>(primitive);
  const V now_t = load<V>(best_t + at);
  const M is_lower = mask_as<V>(now == -1) || mask_as<V>(number < now);
  const M is_better = rays && t >= t_min && (t < now_t || (t == now_t && is_lower));
  store_where(is_better, number, best + at);
  settle_rays(at, is_better, t);
  return !is_none<V>(is_better);
}

HWY_INLINE void FanRays::settle_rays(size_t at, M rays, V t) {
  const V near = 1 / abs(load<V>(direction[kz] + at) * t);
  store_where(rays, t, best_t + at);
  store_where(rays, set<VI>(-1), pending + at);
  store_where(rays, min(near * (1 - kNearSlack) - kUnderflow, kNearMax), low + at);
  store_where(rays, near * (1 + kNearSlack) + kUnderflow, high + at);
}

HWY_INLINE void FanRays::shorten() {
  const auto least = [](auto a, auto b) { return min(a, b); };
  float lowest;
  if constexpr (kRows == 4) {
    const auto row = [&](size_t r) { return load<V>(low + r * kLanes); };
    lowest = least_lane(least(least(row(0), row(1)), least(row(2), row(3))));
  } else {
    fold_rows<kRows>(
        D(), [&](size_t r) { return load<V>(low + r * kLanes); }, least, row_low);
    lowest = row_low[0];
    for (size_t r = 1; r < kRows && !kHasManyRows; ++r) lowest = min_of(lowest, row_low[r]);
    if constexpr (kHasManyRows) {
      using Four = FloatsOf<4>;
      Four rows = load<Four>(row_low);
      for (size_t r = kLanesOf<Four>; r < kRows; r += kLanesOf<Four>)
        rows = min(rows, load<Four>(row_low + r));
      lowest = least_lane(rows);
    }
  }
  z_far = __builtin_inff();
  if (lowest > 0)
    z_far = lowest < __builtin_inff() ? 1 / lowest * (1 + kTimeSlack) : -__builtin_inff();
}

HWY_INLINE FanRays::V FanRays::farthest(size_t at) const {
  const V near = load<V>(low + at), infinity = set<V>(__builtin_inff());
  // A product below the least normal number takes a hundred cycles, and `low` of endless rays is
  // -kUnderflow. So limits beyond 2^100 count as none.
  const V least = set<V>(0x1p-100f);
  const V t = 1 / (max(near, least) * abs(load<V>(direction[kz] + at))) * (1 + kNearSlack);
  return select(near > least, select(near < infinity, t, -infinity), infinity);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
