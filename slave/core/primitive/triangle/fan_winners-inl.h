// SPDX-License-Identifier: Apache-2.0
// Triangles that rays of a fan have hit and whose t is not known yet (FanRays::pending): their
// corners, in the order in which they were hit. Finds t of them.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_FAN_WINNERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_WINNERS_INL_H_
#undef TESSERA_CORE_FAN_WINNERS_INL_H_
#else
#define TESSERA_CORE_FAN_WINNERS_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/ray/fan_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W>
class FanWinners {
  using V = FanRays::V;
  using VI = FanRays::VI;
  using M = FanRays::M;
  static constexpr size_t kLanes = FanRays::kLanes;
  static constexpr int kMax = 2 * kPacketRays;

 public:
  explicit FanWinners(FanRays& fan) : fan_(fan) {}

  HWY_INLINE void clear() { count_ = 0; }
  // Returns: the number of a triangle, for FanRays::pending.
  HWY_INLINE int32_t add(const TriangleBlock<W>& block, size_t lane) {
    if (HWY_UNLIKELY(count_ == kMax)) drop_unused();
    for (size_t k = 0; k < 9; ++k) corners_[k][count_] = block.vertex[k][lane];
    return count_++;
  }
  // Finds t of a ray's best hit where it is pending.
  HWY_INLINE void settle(size_t ray) {
    if (fan_.pending[ray] >= 0) settle_one(ray);
  }
  // The same for some rays of the row that begins at `at`.
  void settle_rays(size_t at, M rays);
  void settle_all();

 private:
  // What rays of a row need of their planes, to find t.
  struct RowPlanes {
    V speed, distance, steepness;
  };
  HWY_NOINLINE void settle_one(size_t ray);
  HWY_INLINE void settle_row(size_t at, M rays, const RowPlanes& planes);
  // Finds t of the rays of the row that begins at `at`, from the planes of the table: for each
  // triangle in turn, or for all of four rays at once.
  HWY_INLINE void settle_by_triangle(size_t at);
  HWY_INLINE void settle_four(size_t at);
  HWY_NOINLINE void drop_unused();

  FanRays& fan_;
  int32_t count_ = 0;
  alignas(64) float corners_[9][kMax];
  PlaneTable<kMax> planes_;
};

template <int W>
void FanWinners<W>::settle_one(size_t ray) {
  float triangle[9], direction[3], speed = 0, t = 0;
  for (size_t k = 0; k < 9; ++k) triangle[k] = corners_[k][fan_.pending[ray]];
  fan_.direction_of(ray, direction);
  const float size = FanRays::length_of(direction);
  if (!plane_t(plane_of(triangle, fan_.origin), direction, size, speed, t))
    t = exact_hit(fan_.origin, direction, triangle).t;
  fan_.settle(ray, t);
}

// Finds t of rays whose planes are known.
template <int W>
void FanWinners<W>::settle_row(size_t at, M rays, const RowPlanes& planes) {
  const V t = planes.distance / planes.speed;
  const M counts = abs(planes.speed) >= planes.steepness * fan_.length_at(at) + kPlaneLeast;
  store_where(rays && counts, t, fan_.best_t + at);
  for (uint32_t rest = bits_of<V>(and_not(counts, rays)); rest != 0; rest &= rest - 1)
    settle_one(at + static_cast<size_t>(__builtin_ctz(rest)));
}

template <int W>
void FanWinners<W>::settle_rays(size_t at, M rays) {
  const VI slots = load<VI>(fan_.pending + at);
  const M is_pending = rays && mask_as<V>(slots > -1);
  for (uint32_t left = bits_of<V>(is_pending); left != 0;) {
    const int32_t slot = fan_.pending[at + static_cast<size_t>(__builtin_ctz(left))];
    float triangle[9];
    for (size_t k = 0; k < 9; ++k) triangle[k] = corners_[k][slot];
    const Plane plane = plane_of(triangle, fan_.origin);
    const M mine = is_pending && mask_as<V>(slots == slot);
    settle_row(at, mine,
               {speed_of(fan_, plane, at), set<V>(plane.distance), set<V>(plane.steepness)});
    left &= ~bits_of<V>(mine);
  }
  fan_.settle_rays(at, is_pending, load<V>(fan_.best_t + at));
}

template <int W>
void FanWinners<W>::settle_all() {
  if (count_ == 0) return;
  if (count_ > 16) drop_unused();
  for (int32_t k = 0; k < count_; k += static_cast<int32_t>(kLanesOf<Doubles>))
    planes_.make(corners_, static_cast<size_t>(k), fan_.origin);
#if HWY_TARGET == HWY_AVX3
  // The planes of up to 16 triangles stay in registers, from which each ray takes its own.
  if (count_ <= 16) {
    const hn::CappedTag<double, 8> dd;
    const hn::CappedTag<int64_t, 8> di;
    const hn::CappedTag<float, 16> df;
    const auto distance = load<V>(planes_.distance), steepness = load<V>(planes_.steepness);
    hn::Vec<decltype(dd)> normal[3][2];
    for (size_t k = 0; k < 3; ++k) {
      normal[k][0] = hn::Load(dd, planes_.normal[k]);
      normal[k][1] = hn::Load(dd, planes_.normal[k] + 8);
    }
    for (size_t at = 0; at < kPacketRays; at += kLanes) {
      const VI slots = load<VI>(fan_.pending + at);
      const M rays = mask_as<V>(slots > -1);
      const auto speed = [&](size_t half) HWY_ATTR {
        const size_t first = at + half * 8;
        const auto number =
            hn::PromoteTo(di, hn::Load(hn::CappedTag<int32_t, 8>(), fan_.pending + first));
        const auto index = hn::IndicesFromVec(dd, number & 7);
        const auto is_upper = hn::RebindMask(dd, number > 7);
        const auto along = [&](size_t axis) HWY_ATTR {
          auto mine = hn::TableLookupLanes(normal[axis][0], index);
          if (count_ > 8)
            mine = hn::IfThenElse(is_upper, hn::TableLookupLanes(normal[axis][1], index), mine);
          return in_double(fan_.direction[axis] + first) * mine;
        };
        return hn::DemoteTo(hn::CappedTag<float, 8>(), along(0) + along(1) + along(2));
      };
      const auto index = hn::IndicesFromVec(df, slots & 15);
      settle_row(at, rays,
                 {hn::Combine(df, speed(1), speed(0)), hn::TableLookupLanes(distance, index),
                  hn::TableLookupLanes(steepness, index)});
    }
    return;
  }
#endif
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    if constexpr (kLanes == 4) {
      settle_four(at);
    } else {
      settle_by_triangle(at);
    }
  }
}

template <int W>
void FanWinners<W>::settle_by_triangle(size_t at) {
  const VI slots = load<VI>(fan_.pending + at);
  uint32_t left = bits_of<VI>(slots > -1);
  while (left != 0) {
    const auto slot =
        static_cast<size_t>(fan_.pending[at + static_cast<size_t>(__builtin_ctz(left))]);
    Plane plane;
    for (size_t k = 0; k < 3; ++k) plane.normal[k] = planes_.normal[k][slot];
    const M rays = mask_as<V>(slots == static_cast<int32_t>(slot));
    settle_row(at, rays,
               {speed_of(fan_, plane, at), set<V>(planes_.distance[slot]),
                set<V>(planes_.steepness[slot])});
    left &= ~bits_of<V>(rays);
  }
}

// Registers are put together from numbers that were loaded one by one: what loads numbers together
// after they were stored one by one has to wait for them.
template <int W>
void FanWinners<W>::settle_four(size_t at) {
  using Four = float __attribute__((vector_size(16)));
  using Two = double __attribute__((vector_size(16)));
  const M rays = mask_as<V>(load<VI>(fan_.pending + at) > -1);
  if (is_none<V>(rays)) return;
  size_t slot[4];  // that of another triangle for a ray that has none
  for (size_t i = 0; i < 4; ++i) slot[i] = static_cast<size_t>(max_of(fan_.pending[at + i], 0));
  const auto speed = [&](size_t first) HWY_ATTR {
    const auto along = [&](size_t axis) HWY_ATTR {
      const double* const normal = planes_.normal[axis];
      const float* const d = fan_.direction[axis] + at + first;
      return Two{static_cast<double>(d[0]), static_cast<double>(d[1])} *
             Two{normal[slot[first]], normal[slot[first + 1]]};
    };
    return along(0) + along(1) + along(2);
  };
  const auto all = [&](const float* table) HWY_ATTR {
    return Four{table[slot[0]], table[slot[1]], table[slot[2]], table[slot[3]]};
  };
  const Two low = speed(0), high = speed(2);
  const Four four[3] = {{static_cast<float>(low[0]), static_cast<float>(low[1]),
                         static_cast<float>(high[0]), static_cast<float>(high[1])},
                        all(planes_.distance),
                        all(planes_.steepness)};
  alignas(16) float numbers[3][4];
  __builtin_memcpy(numbers, four, sizeof numbers);
  settle_row(at, rays, {load<V>(numbers[0]), load<V>(numbers[1]), load<V>(numbers[2])});
}

// Drops triangles that no ray has as its best hit any more.
template <int W>
void FanWinners<W>::drop_unused() {
  int32_t moved[kMax];
  for (int32_t& to : moved) to = -1;
  for (size_t ray = 0; ray < kPacketRays; ++ray) {
    if (fan_.pending[ray] >= 0) moved[fan_.pending[ray]] = 0;
  }
  int32_t count = 0;
  for (int32_t slot = 0; slot < count_; ++slot) {
    if (moved[slot] < 0) continue;
    for (size_t k = 0; k < 9; ++k) corners_[k][count] = corners_[k][slot];
    moved[slot] = count++;
  }
  for (size_t ray = 0; ray < kPacketRays; ++ray) {
    if (fan_.pending[ray] >= 0) fan_.pending[ray] = moved[fan_.pending[ray]];
  }
  count_ = count;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
