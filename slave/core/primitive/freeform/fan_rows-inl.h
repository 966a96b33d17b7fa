// SPDX-License-Identifier: Apache-2.0
// Which rows of a fan may meet a sub-patch: one test of the rectangles in which they lie, a row per
// lane, before rays are asked one by one (patch_filter-inl.h). Most sub-patches of a leaf are met
// by few rows or none.
//
// Rays are (u, v, 1) along the axes of the frustum, from o in the frame. One that meets the
// sub-patch has o_a + t d_a = x + rest_a, by x, and o_n + t d_n = rest_n. Without t, that is
//   G_a = o_a d_n - o_n d_a = (x + rest_a) d_n - rest_n d_a,
//   |G_a| <= (kBorder + reach_a) |d_n| + reach_n |d_a|,
// and so by y. G and d are linear in u and v. Over a rectangle with the middle m and half sides h,
// |G_a| is at least |G_a(m)| - h |grad G_a|, and |d_r| at most |d_r(m)| + h |grad d_r|.
//
// Roundings, with u, N_r and S of patch_filter-inl.h. Slopes are off by 3 u of their size, middle
// and half sides by u each, sums of three products by 3 u of the sizes of all terms: d_r by less
// than 11 u N_r S. Of o, made in double, u of its size is lost, so numbers of G_a are off by 3 u of
// the terms that they are differences of, and G_a by 14 u (|o_a| N_n + |o_n| N_a) S. 16 u stands
// for both. Far away, o itself is off by 2^-50 N_r R, and the complete solver takes for a hit what
// it sees within 2^-42 R, which makes less than 2^-40 N_r R with the length of a direction: G_a has
// room for 2^-38 N_a N_n R S for each of its two terms. Where d_n may be too small for the filter,
// and where any of this is not a number, rows stay.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_FAN_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_ROWS_INL_H_
#undef TESSERA_CORE_FAN_ROWS_INL_H_
#else
#define TESSERA_CORE_FAN_ROWS_INL_H_
#endif

#include "slave/core/ray/fan_rays-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What stands between a bound and what is compared with it.
struct PatchFilterRoom {
  // Distance that makes room for what may be off by `off` on each axis.
  static constexpr float kFartherPerOff = 1 / (16 * kRoundoff);
  static constexpr float kRoom = 16 * kRoundoff;        // see above, and patch_filter-inl.h
  static constexpr float kTooFlat = 64 * kRoundoff;     // |d_n| over N_n S
  static constexpr float kLimitSlack = 32 * kRoundoff;  // of t_min and the best t
  static constexpr float kBorder = 1 + 0x1p-18f;        // of the square, where neighbours overlap
};

class FanRows : PatchFilterRoom {
  static constexpr size_t kRows = FanRays::kRows;
  using V = FloatsOf<(kRows < kLaneCount ? kRows : kLaneCount)>;

 public:
  static constexpr uint64_t kAll = ~uint64_t{0} >> (64 - kRows);

  // Requires: the fan is set up.
  HWY_INLINE void set_to(const FanRays& fan) {
    if constexpr (FanRays::kCullsRows) {
      set_slopes(0, fan.row_u[0], fan.row_u[1]);
      set_slopes(1, fan.row_v[0], fan.row_v[1]);
    } else {
      fold_slopes(0, fan.ray_u);
      fold_slopes(1, fan.ray_v);
    }
    steepness_ = fan.steepness;
  }

  // Returns: the bits of rows. o: where rays begin, in the frame; norm: N_r; reach: R.
  HWY_INLINE uint64_t possible(const FanRays& fan, const SubPatch& part, const float (&o)[3],
                               const float (&norm)[3], float reach) const {
    float by_u[3], by_v[3], rest[3];  // of d_r
    for (int r = 0; r < 3; ++r) {
      by_u[r] = part.frame[r][fan.kx];
      by_v[r] = part.frame[r][fan.ky];
      rest[r] = part.frame[r][fan.kz] * fan.side;
    }
    const float size_n = norm[2] * steepness_, flat = 2 * kTooFlat * size_n;
    float to_u[2], to_v[2], to_rest[2], wide[2], off[2];  // of G_a, and what it is compared with
    for (int a = 0; a < 2; ++a) {
      to_u[a] = o[a] * by_u[2] - o[2] * by_u[a];
      to_v[a] = o[a] * by_v[2] - o[2] * by_v[a];
      to_rest[a] = o[a] * rest[2] - o[2] * rest[a];
      wide[a] = kBorder + part.reach[a];
      const float size_a = norm[a] * steepness_;
      off[a] = kRoom * (abs_of(o[a]) * size_n + abs_of(o[2]) * size_a + wide[a] * size_n +
                        part.reach[2] * size_a) +
               0x1p-37f * reach * norm[a] * size_n;
    }
    uint64_t rows = 0;
    for (size_t first = 0; first < kRows; first += kLanesOf<V>) {
      const V u = load<V>(middle_[0] + first), v = load<V>(middle_[1] + first);
      const V half_u = load<V>(half_[0] + first), half_v = load<V>(half_[1] + first);
      const auto at = [&](float x, float y, float z) HWY_ATTR {
        return abs(mul_add(u, set<V>(x), mul_add(v, set<V>(y), set<V>(z))));
      };
      const auto beside = [&](float x, float y) HWY_ATTR {
        return mul_add(half_u, set<V>(abs_of(x)), half_v * abs_of(y));
      };
      const V n = at(by_u[2], by_v[2], rest[2]), n_beside = beside(by_u[2], by_v[2]);
      auto is_out = n < set<V>(0);
      for (int a = 0; a < 2; ++a) {
        const V most = at(by_u[a], by_v[a], rest[a]) + beside(by_u[a], by_v[a]);
        const V least = at(to_u[a], to_v[a], to_rest[a]) - beside(to_u[a], to_v[a]);
        const V within = mul_add(n + n_beside, set<V>(wide[a]),
                                 mul_add(most, set<V>(part.reach[2]), set<V>(off[a])));
        is_out = is_out || least > within;
      }
      is_out = is_out && n - n_beside > set<V>(flat);
      rows |= uint64_t{~bits_of<V>(is_out) & ((1u << kLanesOf<V>)-1)} << first;
    }
    return rows;
  }

 private:
  HWY_INLINE void fold_slopes(int a, const float* slopes) {
    const auto row = [&](size_t r) HWY_ATTR { return load<Floats>(slopes + r * kLaneCount); };
    alignas(64) float low[kRows], high[kRows];
    fold_rows<kRows>(
        TagOf<Floats>(), row, [](auto x, auto y) { return min(x, y); }, low);
    fold_rows<kRows>(
        TagOf<Floats>(), row, [](auto x, auto y) { return max(x, y); }, high);
    set_slopes(a, low, high);
  }
  HWY_INLINE void set_slopes(int a, const float* low, const float* high) {
    for (size_t first = 0; first < kRows; first += kLanesOf<V>) {
      const V from = load<V>(low + first), to = load<V>(high + first);
      store(0.5f * (from + to), middle_[a] + first);
      store(0.5f * (to - from), half_[a] + first);
    }
  }

  alignas(64) float middle_[2][kRows], half_[2][kRows];  // by u, by v
  float steepness_;
};

// Whether rows are worth asking about: those of fans, but where a ray is a row.
template <class Rays>
constexpr bool kHasRows = std::is_same_v<Rays, FanRays> && (kLaneCount > 1);

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
