// SPDX-License-Identifier: Apache-2.0
// The test of one ray against the triangles of a block, all at once.
//
// Method. As in triangle_fan-inl.h, the signs of three edge functions decide where they are sure,
// and exact_hit() where they are not. Here the triangle is sheared so that the ray is the z axis,
// after Woop, Benthin, Wald, 2013. With s the largest coordinate of a corner from the origin and M
// the largest across the ray, after the shear, an edge function is off by at most
//    2 u M M    one product and the fused difference
//   12 u s D    corners, off by 4 u s per axis (moved, shear of two roundings, fused): the ray's
//               distance from an edge of extent D <= 2 M is known to 6 u s
// whatever the ray, and a ray that is outside of one edge by more is outside the triangle,
// whichever way the triangle is turned (see triangle_fan-inl.h). M <= 2 s. So 32 u s M is enough
// for all three, with s bounded by the whole scene.
//
// Where a line surely passes through a triangle, its t is the mean of the corners' t, weighted by
// the edge functions. Each weight is off by at most 2 tolerances of the sum of the three, all of
// them by 6, so t is known to that part of what the corners' t differ by, and to the roundings.
// That rules triangles out, and is all that any-hit needs, before plane-inl.h says what t is.
//
// Where many triangles of a block are open, elsewhere-inl.h rules most of them out before the rest
// is decided.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#undef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_RAY_INL_H_
#endif

#include "slave/core/primitive/triangle/elsewhere-inl.h"
#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Tolerance of an edge function, per largest coordinate of a corner from the origin and per largest
// across the ray; see above.
constexpr float kEdgeTolerance = 33 * kRoundoff;

template <int W, bool kAny>
class TriangleRay {
 public:
  // What is known of a block's triangles, by bits.
  struct Candidates {
    uint32_t possible;  // the line may pass through within the limits of t
    uint32_t sure;      // it does pass through
    uint32_t certain;   // it does so within the limits; for any-hit only
  };

  explicit TriangleRay(OneRay& ray) : ray_(ray) {}

  // Requires, before tests: the ray is set up.
  HWY_INLINE void prepare() { tolerance_ = kEdgeTolerance * ray_.reach; }
  HWY_INLINE void test(const TriangleBlock<W>& block);
  // What test() does, in two steps. Requires: a register has room for a whole block.
  HWY_INLINE Candidates look(const TriangleBlock<W>& block) const {
    return candidates<false>(block, 0);
  }
  HWY_INLINE void settle(const TriangleBlock<W>& block, const Candidates& found) {
    settle(block, 0, found);
  }
  bool has_hit() const { return ray_.has_hit(); }

 private:
  using V = FloatsOf<W>;  // triangles
  using M = MaskOf<V>;
  static constexpr size_t kStep = kLanesOf<V>;
  // Up to so many open triangles of a step are decided at once, which costs no more than
  // elsewhere().
  static constexpr int kFew = static_cast<int>(kStep / 4);

  // kIsAlone: for a ray by itself, which gains by a branch where no triangle is possible, and does
  // not gain by narrowing t for closest hits. Rays in flight have it the other way round.
  template <bool kIsAlone>
  HWY_INLINE Candidates candidates(const TriangleBlock<W>& block, size_t first) const;
  HWY_INLINE void settle(const TriangleBlock<W>& block, size_t first, const Candidates& found);
  HWY_INLINE void narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low, V& high) const;
  HWY_INLINE void test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure);
  HWY_NOINLINE uint32_t elsewhere(const TriangleBlock<W>& block, size_t first) const;
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, bool counts, float& t) const;

  OneRay& ray_;
  float tolerance_;  // of an edge function per size of its triangle across the ray
};

template <int W, bool kAny>
template <bool kIsAlone>
typename TriangleRay<W, kAny>::Candidates TriangleRay<W, kAny>::candidates(
    const TriangleBlock<W>& block, size_t first) const {
  V x[3], y[3], t[3], size = set<V>(0);
  for (int c = 0; c < 3; ++c) {
    // Vectors go from the corner to the origin, which saves loading the corner; the edge functions
    // are the same.
    const auto back = [&](int axis) {
      return ray_.origin[axis] - load<V>(block.vertex[3 * c + axis] + first);
    };
    t[c] = back(ray_.kz) * -ray_.inverse[ray_.kz];
    x[c] = mul_add(set<V>(ray_.slope[ray_.kx]), t[c], back(ray_.kx));
    y[c] = mul_add(set<V>(ray_.slope[ray_.ky]), t[c], back(ray_.ky));
    size = max(size, max(abs(x[c]), abs(y[c])));
  }
  const auto edge_of = [&](int c, int e) { return mul_sub(x[c], y[e], y[c] * x[e]); };
  const V edge[3] = {edge_of(1, 2), edge_of(2, 0), edge_of(0, 1)};
  const V tolerance = mul_add(size, set<V>(tolerance_), set<V>(kUnderflow));
  const V least = min(min(edge[0], edge[1]), edge[2]);
  const V greatest = max(max(edge[0], edge[1]), edge[2]);
  const V depth = max(least, -greatest);  // how far inside, whichever side faces the ray
  M is_possible = depth >= -tolerance;
  if (kAny) {
    const auto number = load<IntOf<V>>(reinterpret_cast<const int32_t*>(block.primitive) + first);
    const auto is_other = [&](int32_t excluded) { return number != excluded; };
    const auto is_met = is_other(ray_.excluded[0]) && is_other(ray_.excluded[1]);
    is_possible = is_possible && mask_as<V>(is_met);
  }
  if (kIsAlone && is_none<V>(is_possible)) return {0, 0, 0};

  const M is_sure = is_possible && depth > tolerance;
  V low = min(min(t[0], t[1]), t[2]), high = max(max(t[0], t[1]), t[2]);
  if (kAny || !kIsAlone) narrow(edge, t, tolerance, is_sure, low, high);
  const M is_near = low <= ray_.far_limit && high >= ray_.near_limit;
  Candidates found{bits_of<V>(is_possible && is_near), bits_of<V>(is_sure), 0};
  if (kAny) {
    const V inner_near = set<V>(moved(ray_.near_limit, 2 * kTimeSlack));
    const V inner_far = set<V>(moved(ray_.far_limit, -2 * kTimeSlack));
    const M is_within = low > inner_near && high < inner_far;
    found.certain = found.sure & bits_of<V>(is_within);
  }
  return found;
}

// Narrows the interval of t in which the line meets a triangle, as far as is known. t [3]: of the
// corners. Roundings are 10 u of the largest of these, which is no more than t itself and what they
// differ by: the limits have been moved by 16 u of the one, the interval is by 16 u of the other.
template <int W, bool kAny>
void TriangleRay<W, kAny>::narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low,
                                  V& high) const {
  const V per_sum = 1 / (edge[0] + edge[1] + edge[2]);
  const auto weight = [&](int c) { return edge[c] * per_sum; };  // t times an edge may overflow
  const V middle = mul_add(weight(0), t[0], mul_add(weight(1), t[1], weight(2) * t[2]));
  const V off = tolerance * 8;
  const V share = mul_add(abs(per_sum), off, set<V>(16 * kRoundoff));
  const V spread = (high - low) * share;
  low = select(is_sure, middle - spread, low);
  high = select(is_sure, middle + spread, high);
}

template <int W, bool kAny>
void TriangleRay<W, kAny>::test(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  for (size_t first = 0; first < W; first += kStep) {
    const Candidates found = candidates<true>(block, first);
    settle(block, first, found);
    if (kAny && found.certain != 0) return;
  }
}

template <int W, bool kAny>
void TriangleRay<W, kAny>::settle(const TriangleBlock<W>& block, size_t first,
                                  const Candidates& found) {
  if (kAny && found.certain != 0) {
    const auto lane = first + static_cast<size_t>(__builtin_ctz(found.certain));
    return ray_.template accept<kAny>(ray_.best_t, static_cast<int32_t>(block.primitive[lane]));
  }
  uint32_t bits = found.possible;
  const uint32_t open = bits & ~found.sure;
  if (HWY_UNLIKELY(__builtin_popcount(open) > kFew)) bits &= ~(open & elsewhere(block, first));
  for (; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(bits));
    test_triangle(block, first + lane, found.sure >> lane & 1u);
  }
}

// Returns: bits of triangles, from `first` on, that the ray surely misses.
template <int W, bool kAny>
uint32_t TriangleRay<W, kAny>::elsewhere(const TriangleBlock<W>& block, size_t first) const {
  uint32_t found = 0;
  for (size_t at = 0; at < kStep; at += kLanesOf<Doubles>) {
    const auto corner = [&](size_t k) HWY_ATTR { return in_double(block.vertex[k] + first + at); };
    const auto of = [](const float* v) {
      return [v](size_t k) HWY_ATTR { return set<Doubles>(static_cast<double>(v[k])); };
    };
    const auto out = is_elsewhere(corner, of(ray_.origin), of(ray_.direction));
    found |= uint32_t{bits_of<Doubles>(out)} << at;
  }
  return found;
}

// Decides a triangle that candidates() leaves open. counts: whether t is that of the plane; else it
// is found.
template <int W, bool kAny>
bool TriangleRay<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, bool counts,
                                  float& t) const {
  TESSERA_COUNT(exact, 1);
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  if (counts) return is_exact_hit(ray_.origin, ray_.direction, triangle);
  const ExactHit exact = exact_hit(ray_.origin, ray_.direction, triangle);
  t = exact.t;
  return exact.is_hit;
}

template <int W, bool kAny>
void TriangleRay<W, kAny>::test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure) {
  TESSERA_COUNT(candidates, 1);
  const Plane plane = plane_of(block, lane, ray_.origin);
  float t = 0, speed = 0;
  const bool counts = plane_t(plane, ray_.direction, ray_.size, speed, t);
  const auto number = static_cast<int32_t>(block.primitive[lane]);
  if (counts && !ray_.is_nearer(t, number)) return;
  if (!counts || !is_sure) {
    if (!decide(block, lane, counts, t)) return;
    if (!counts && !ray_.is_nearer(t, number)) return;
  }
  ray_.template accept<kAny>(t, number);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
