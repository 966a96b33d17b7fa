// SPDX-License-Identifier: Apache-2.0
// Pairs of a ray and a triangle that it may hit, decided side by side: rays that are traced
// together have one or two such triangles each, and t takes some sixty operations in double, which
// cost a register of pairs little more than one of them.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_PAIRS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_PAIRS_INL_H_
#undef TESSERA_CORE_TRIANGLE_PAIRS_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_PAIRS_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/ray/axes-inl.h"
#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3

// kAny: whether any hit will do.
template <bool kAny>
class TrianglePairs {
  using Quad = Axes<FloatsOf<4>>;

 public:
  // Adds a pair. corners: the three of them, by axis. is_sure: whether the line surely passes
  // through the triangle.
  HWY_INLINE void add(OneRay& ray, const Quad (&corners)[3], uint32_t number, bool is_sure);
  // Decides what was added: rays have their nearest hit then, or any.
  HWY_NOINLINE void decide();

 private:
  using VF = FloatOf<Doubles>;
  static constexpr size_t kMost = 64, kStep = kLanesOf<Doubles>;

  // A cache line.
  struct alignas(64) Pair {
    float by_axis[3][4];  // A, B, C, and where the ray begins
    float way[4];         // the ray's direction, and the sum of its sizes
  };
  // Of kStep pairs.
  struct Columns {
    Doubles corner[9], origin[3], direction[3];
    VF size;
  };

  static HWY_INLINE Columns columns_of(const Pair* pairs);
  HWY_INLINE void find_t(size_t at);
  HWY_INLINE void settle(size_t i);

  Pair pair_[kMost];
  alignas(64) float t_[kMost], counts_[kMost];
  OneRay* ray_[kMost];
  int32_t number_[kMost];
  bool is_sure_[kMost];
  size_t count_ = 0;
};

template <bool kAny>
void TrianglePairs<kAny>::add(OneRay& ray, const Quad (&corners)[3], uint32_t number,
                              bool is_sure) {
  Pair& pair = pair_[count_];
  for (size_t a = 0; a < 3; ++a)
    corners[a].with_fourth(ray.origin[a]).store_each([&](size_t) { return pair.by_axis[a]; });
  const auto direction = Quad::load_each([&](size_t) { return ray.direction; });
  direction.with_fourth(ray.size).store_each([&](size_t) { return pair.way; });
  ray_[count_] = &ray;
  number_[count_] = static_cast<int32_t>(number);
  is_sure_[count_] = is_sure;
  if (HWY_UNLIKELY(++count_ == kMost)) decide();
}

// The pairs are turned four by four; columns[c] of four has number c of each axis, then of the way.
template <bool kAny>
typename TrianglePairs<kAny>::Columns TrianglePairs<kAny>::columns_of(const Pair* pairs) {
  using V = FloatsOf<16>;
  using H = FloatsOf<8>;
  const TagOf<V> d;
  const hn::Repartition<uint64_t, TagOf<V>> twos;
  V columns[2][4];
  for (size_t half = 0; half < 2; ++half) {
    V row[4];
    for (size_t r = 0; r < 4; ++r) row[r] = load<V>(pairs[4 * half + r].by_axis[0]);
    const auto low = [&](size_t r) HWY_ATTR {
      return hn::BitCast(twos, hn::InterleaveLower(d, row[r], row[r + 1]));
    };
    const auto high = [&](size_t r) HWY_ATTR {
      return hn::BitCast(twos, hn::InterleaveUpper(d, row[r], row[r + 1]));
    };
    columns[half][0] = hn::BitCast(d, hn::InterleaveLower(twos, low(0), low(2)));
    columns[half][1] = hn::BitCast(d, hn::InterleaveUpper(twos, low(0), low(2)));
    columns[half][2] = hn::BitCast(d, hn::InterleaveLower(twos, high(0), high(2)));
    columns[half][3] = hn::BitCast(d, hn::InterleaveUpper(twos, high(0), high(2)));
  }
  const auto half_of = [](V v, size_t block) HWY_ATTR {
    return block < 2 ? hn::LowerHalf(TagOf<H>(), v) : hn::UpperHalf(TagOf<H>(), v);
  };
  const auto quad_of = [&](V v, size_t block) HWY_ATTR {
    const TagOf<FloatsOf<4>> quad;
    const H half = half_of(v, block);
    return block % 2 == 0 ? hn::LowerHalf(quad, half) : hn::UpperHalf(quad, half);
  };
  const auto column = [&](size_t c, size_t block) HWY_ATTR {
    return hn::Combine(TagOf<H>(), quad_of(columns[1][c], block), quad_of(columns[0][c], block));
  };
  Columns of;
  for (size_t a = 0; a < 3; ++a) {
    for (size_t c = 0; c < 3; ++c) of.corner[3 * c + a] = convert<Doubles>(column(c, a));
    of.origin[a] = convert<Doubles>(column(3, a));
    of.direction[a] = convert<Doubles>(column(a, 3));
  }
  of.size = column(3, 3);
  return of;
}

template <bool kAny>
void TrianglePairs<kAny>::find_t(size_t at) {
  const Columns of = columns_of(pair_ + at);
  const auto plane = PlaneLanes::through([&](size_t k) HWY_ATTR { return of.corner[k]; },
                                         [&](size_t a) HWY_ATTR { return of.origin[a]; });
  const auto along = [&](size_t a) HWY_ATTR { return of.direction[a] * plane.normal[a]; };
  const VF speed = convert<VF>((along(0) + along(1)) + along(2));
  store(plane.distance / speed, t_ + at);
  const auto counts = abs(speed) >= plane.steepness * of.size + kPlaneLeast;
  store(zero_unless(counts, set<VF>(1)), counts_ + at);
}

// As TriangleRay decides a triangle.
template <bool kAny>
void TrianglePairs<kAny>::settle(size_t i) {
  TESSERA_COUNT(candidates, 1);
  OneRay& ray = *ray_[i];
  float t = t_[i];
  const bool counts = counts_[i] != 0;
  if (counts && !ray.is_nearer(t, number_[i])) return;
  if (HWY_UNLIKELY(!counts || !is_sure_[i])) {
    TESSERA_COUNT(exact, 1);
    float triangle[9];
    for (size_t k = 0; k < 9; ++k) triangle[k] = pair_[i].by_axis[k % 3][k / 3];
    if (counts) {
      if (!is_exact_hit(ray.origin, ray.direction, triangle)) return;
    } else {
      const ExactHit exact = exact_hit(ray.origin, ray.direction, triangle);
      t = exact.t;
      if (!exact.is_hit || !ray.is_nearer(t, number_[i])) return;
    }
  }
  ray.template accept<kAny>(t, number_[i]);
}

// Pairs behind the last are of earlier times, or nothing at all; nobody asks what comes of them.
template <bool kAny>
void TrianglePairs<kAny>::decide() {
  for (size_t at = 0; at < count_; at += kStep) find_t(at);
  for (size_t i = 0; i < count_; ++i) settle(i);
  count_ = 0;
}

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
