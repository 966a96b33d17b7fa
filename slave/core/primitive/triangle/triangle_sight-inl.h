// SPDX-License-Identifier: Apache-2.0
// What one ray may hit of a block's triangles, all at once, before any of them is decided.
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
// Blur. The ray and the triangles may stand for others, as in the object space of an instance,
// whose coordinates across the sheared ray are off by at most e more, and the corners' t by at most
// m. An edge function, a determinant of two corners across the ray, is then off by at most 4 M e +
// 2 e e more, which is less than 4 e (M + e).
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/triangle_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_SIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_SIGHT_INL_H_
#undef TESSERA_CORE_TRIANGLE_SIGHT_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_SIGHT_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Tolerance of an edge function, per largest coordinate of a corner from the origin and per largest
// across the ray; see above.
constexpr float kEdgeTolerance = 33 * kRoundoff;

// What is known of a block's triangles, by bits.
struct Candidates {
  uint32_t possible;  // the line may pass through within the limits of t
  uint32_t sure;      // it does pass through
  uint32_t certain;   // it does so within the limits; for any-hit only
};

template <int W, bool kAny>
class TriangleSight {
  using V = FloatsOf<W>;  // triangles
  using M = MaskOf<V>;

 public:
  static constexpr size_t kStep = kLanesOf<V>;

  explicit TriangleSight(const BoxRay& ray) : ray_(ray) {}

  // Requires, before look(): the ray is set up. across, along: e and m, see above.
  HWY_INLINE void prepare(float across = 0, float along = 0) {
    tolerance_ = kEdgeTolerance * ray_.reach + 4.25f * across;
    across_ = across;
    along_ = along;
  }
  // Looks at the triangles `first` to first + kStep - 1. excluded [2]: numbers of triangles that an
  // any-hit ray does not meet. kIsAlone: for a ray by itself, which gains by a branch where no
  // triangle is possible, and does not gain by narrowing t for closest hits. Rays in flight have it
  // the other way round. kIsBlurred: whether what prepare() was given is not 0.
  template <bool kIsAlone, bool kIsBlurred = false>
  HWY_INLINE Candidates look(const TriangleBlock<W>& block, size_t first,
                             const int32_t* excluded) const;

 private:
  HWY_INLINE void narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low, V& high) const;

  const BoxRay& ray_;
  float tolerance_;  // of an edge function per size of its triangle across the ray
  float across_, along_;
};

template <int W, bool kAny>
template <bool kIsAlone, bool kIsBlurred>
Candidates TriangleSight<W, kAny>::look(const TriangleBlock<W>& block, size_t first,
                                        const int32_t* excluded) const {
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
  if (kIsBlurred) size = size + across_;
  const auto edge_of = [&](int c, int e) { return mul_sub(x[c], y[e], y[c] * x[e]); };
  const V edge[3] = {edge_of(1, 2), edge_of(2, 0), edge_of(0, 1)};
  const V tolerance = mul_add(size, set<V>(tolerance_), set<V>(kUnderflow));
  const V least = min(min(edge[0], edge[1]), edge[2]);
  const V greatest = max(max(edge[0], edge[1]), edge[2]);
  const V depth = max(least, -greatest);  // how far inside, whichever side faces the ray
  M is_possible = depth >= -tolerance;
  if (kAny) {
    const auto number = load<IntOf<V>>(reinterpret_cast<const int32_t*>(block.primitive) + first);
    const auto is_other = [&](int32_t other) { return number != other; };
    const auto is_met = is_other(excluded[0]) && is_other(excluded[1]);
    is_possible = is_possible && mask_as<V>(is_met);
  }
  if (kIsAlone && is_none<V>(is_possible)) return {0, 0, 0};

  const M is_sure = is_possible && depth > tolerance;
  V low = min(min(t[0], t[1]), t[2]), high = max(max(t[0], t[1]), t[2]);
  if (kAny || !kIsAlone) narrow(edge, t, tolerance, is_sure, low, high);
  if (kIsBlurred) {
    low = low - set<V>(along_);
    high = high + along_;
  }
  const M is_near = low <= ray_.far_limit && high >= ray_.near_limit;
  Candidates found{bits_of<V>(is_possible && is_near), bits_of<V>(is_sure), 0};
  if (kAny) {
    // Limits have been moved out by kTimeSlack, and by twice that in other spaces.
    constexpr float kInward = (kIsBlurred ? 4 : 2) * kTimeSlack;
    const V inner_near = set<V>(moved(ray_.near_limit, kInward));
    const V inner_far = set<V>(moved(ray_.far_limit, -kInward));
    const M is_within = low > inner_near && high < inner_far;
    found.certain = found.sure & bits_of<V>(is_within);
  }
  return found;
}

// Narrows the interval of t in which the line meets a triangle, as far as is known. t [3]: of the
// corners. Roundings are 10 u of the largest of these, which is no more than t itself and what they
// differ by: the limits have been moved by 16 u of the one, the interval is by 16 u of the other.
template <int W, bool kAny>
void TriangleSight<W, kAny>::narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low,
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

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
