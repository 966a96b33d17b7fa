// SPDX-License-Identifier: Apache-2.0
// Where a ray meets the plane of a triangle, by the same operations in every kernel, so that t is
// the same to the bit on every path and instruction set.
//
// N = (B - A) x (C - A), scaled by a power of two to about 1, t = N.(A - O) / N.D. Numerator and
// denominator are computed in double, rounded to float32, and divided there: differences of float32
// are exact in double but for exponents 29 apart, and no product of three leaves its range. Values
// may cancel in N and in the two products. With w = 2^-53 and c the largest sum of the sizes of the
// two products in a component of N, and |.| the sum of components, N.D is off by less than 8 w c
// |D| and N.(A - O) by less than 8 w c |A - O|. Both count where they are at least 2^-24 c |D| and
// 2^-24 c |A - O|: t is then good to 2^-25 and the three roundings to float32. Where one of them is
// less (a ray within some 2^-24 of the plane of a well-shaped triangle), or where they come near
// the ends of float32, exact_hit() gives t instead. These tests are part of the definition of t,
// hence the same everywhere.
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_PLANE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLANE_INL_H_
#undef TESSERA_CORE_PLANE_INL_H_
#else
#define TESSERA_CORE_PLANE_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// A magnitude below this one or above its reciprocal is not trusted in a quotient of float32.
constexpr float kPlaneLeast = 0x1p-100f;

struct Plane {
  double scale;  // of N
  double least;  // 2^-24 c, scaled
  double normal[3];
  float distance;   // N.(A - O)
  float steepness;  // t counts where |N.D| >= steepness * (|Dx| + |Dy| + |Dz|) + kPlaneLeast;
                    // NaN: nowhere
};

// What a plane is made of. T: double, or Doubles, one triangle per lane.
template <class T>
struct PlaneTerms {
  T scale, least, normal[3];  // as of Plane
  T distance, reach;          // N.(A - O), and the sum of the sizes of A - O
};

// corner(k): coordinate k of A, B, C, in [0, 9). origin(k): of the ray's origin.
template <class T, class Corner, class Origin>
HWY_INLINE PlaneTerms<T> plane_terms(const Corner& corner, const Origin& origin) {
  T a[3], b[3], c[3];
  for (size_t k = 0; k < 3; ++k) {
    a[k] = corner(k) - origin(k);
    b[k] = corner(3 + k) - corner(k);
    c[k] = corner(6 + k) - corner(k);
  }
  const T yz = b[1] * c[2], zy = b[2] * c[1], zx = b[2] * c[0], xz = b[0] * c[2], xy = b[0] * c[1],
          yx = b[1] * c[0];
  const T size =
      max_of(abs_of(yz) + abs_of(zy), max_of(abs_of(zx) + abs_of(xz), abs_of(xy) + abs_of(yx)));
  PlaneTerms<T> plane;
  plane.scale = inverse_power(size);
  plane.normal[0] = (yz - zy) * plane.scale;
  plane.normal[1] = (zx - xz) * plane.scale;
  plane.normal[2] = (xy - yx) * plane.scale;
  plane.distance = (plane.normal[0] * a[0] + plane.normal[1] * a[1]) + plane.normal[2] * a[2];
  plane.least = size * plane.scale * 0x1p-24;
  plane.reach = abs_of(a[0]) + abs_of(a[1]) + abs_of(a[2]);
  return plane;
}

template <class Corner>
HWY_INLINE Plane plane_through(const Corner& corner, const float* origin) {
  const auto terms =
      plane_terms<double>(corner, [&](size_t k) { return static_cast<double>(origin[k]); });
  Plane plane{terms.scale,
              terms.least,
              {terms.normal[0], terms.normal[1], terms.normal[2]},
              static_cast<float>(terms.distance),
              static_cast<float>(terms.least)};
  const bool is_good = abs_of(terms.distance) >= terms.least * terms.reach &&
                       abs_of(plane.distance) >= kPlaneLeast &&
                       abs_of(plane.distance) <= 1 / kPlaneLeast;
  if (!is_good) plane.steepness = __builtin_nanf("");
  return plane;
}
template <int W>
HWY_INLINE Plane plane_of(const TriangleBlock<W>& block, size_t lane, const float* origin) {
  return plane_through([&](size_t k) { return static_cast<double>(block.vertex[k][lane]); },
                       origin);
}
// Shape: triangle [9].
HWY_INLINE Plane plane_of(const float* triangle, const float* origin) {
  return plane_through([&](size_t k) { return static_cast<double>(triangle[k]); }, origin);
}

// Planes as of Plane, one per lane of a register of doubles.
struct PlaneLanes {
  using VF = FloatOf<Doubles>;

  Doubles normal[3];
  VF distance, steepness;

  template <class Corner, class Origin>
  static HWY_INLINE PlaneLanes through(const Corner& corner, const Origin& origin) {
    const auto terms = plane_terms<Doubles>(corner, origin);
    const VF distance = convert<VF>(terms.distance);
    const auto is_clear = abs(terms.distance) >= terms.least * terms.reach;
    const VF clear = convert<VF>(zero_unless(is_clear, set<Doubles>(1)));
    const auto is_good =
        clear > 0 && abs(distance) >= kPlaneLeast && abs(distance) <= 1 / kPlaneLeast;
    return {{terms.normal[0], terms.normal[1], terms.normal[2]},
            distance,
            select(is_good, convert<VF>(terms.least), set<VF>(__builtin_nanf("")))};
  }
};

// The planes of up to kMost triangles.
template <size_t kMost>
struct PlaneTable {
  alignas(64) double normal[3][kMost];
  alignas(64) float distance[kMost], steepness[kMost];

  // Makes the planes of as many triangles from `at` on as a register of doubles has lanes. corners
  // [9][kMost].
  HWY_INLINE void make(const float (*corners)[kMost], size_t at, const float* origin) {
    const auto plane = PlaneLanes::through(
        [&](size_t k) HWY_ATTR { return in_double(corners[k] + at); },
        [&](size_t k) HWY_ATTR { return set<Doubles>(static_cast<double>(origin[k])); });
    for (size_t k = 0; k < 3; ++k) store(plane.normal[k], normal[k] + at);
    store(plane.distance, distance + at);
    store(plane.steepness, steepness + at);
  }
};

// Finds N.D and t of one ray; FanWinners has the same in lanes. size: |D|. Returns: whether t
// counts.
HWY_INLINE bool plane_t(const Plane& plane, const float* direction, float size, float& speed,
                        float& t) {
  const double dx = static_cast<double>(direction[0]), dy = static_cast<double>(direction[1]),
               dz = static_cast<double>(direction[2]);
  speed = static_cast<float>((dx * plane.normal[0] + dy * plane.normal[1]) + dz * plane.normal[2]);
  t = plane.distance / speed;
  return abs_of(speed) >= plane.steepness * size + kPlaneLeast;
}

// N.D of a row of rays, by the operations of plane_t().
template <class Rays>
HWY_INLINE typename Rays::V speed_of(const Rays& rays, const Plane& plane, size_t at) {
  const hn::CappedTag<double, Rays::kLanes> d;
  const hn::Rebind<float, decltype(d)> part;
  const auto speed = [&](size_t first) {
    const auto along = [&](size_t axis) {
      const auto component = hn::PromoteTo(d, hn::Load(part, rays.direction[axis] + first));
      return hn::Mul(component, hn::Set(d, plane.normal[axis]));
    };
    return hn::DemoteTo(part, hn::Add(hn::Add(along(0), along(1)), along(2)));
  };
  return halves(typename Rays::D(),
                [&](size_t half) { return speed(at + half * Rays::kLanes / 2); });
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
