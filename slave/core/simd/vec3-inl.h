// SPDX-License-Identifier: Apache-2.0
// Vec3f of common/math in lanes, to the bit: every operation in the same order of roundings.
// Threads. Pure functions.
#if defined(TESSERA_CORE_VEC3_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_VEC3_INL_H_
#undef TESSERA_CORE_VEC3_INL_H_
#else
#define TESSERA_CORE_VEC3_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Tag: of float or double.
template <class Tag>
struct Vec3 {
  using V = hn::Vec<Tag>;
  V x, y, z;

  friend HWY_INLINE Vec3 operator+(Vec3 a, Vec3 b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
  }
  friend HWY_INLINE Vec3 operator-(Vec3 a, Vec3 b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
  }
  friend HWY_INLINE Vec3 operator*(Vec3 a, V s) {
    return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
  }
  // By component.
  friend HWY_INLINE Vec3 operator*(Vec3 a, Vec3 b) {
    return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
  }
  friend HWY_INLINE V dot(Vec3 a, Vec3 b) {
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
  }
  friend HWY_INLINE Vec3 cross(Vec3 a, Vec3 b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
  }
  friend HWY_INLINE Vec3 abs(Vec3 a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
  friend HWY_INLINE V largest(Vec3 a) { return hn::Max(a.x, hn::Max(a.y, a.z)); }
  friend HWY_INLINE V length(Vec3 a) { return hn::Sqrt(dot(a, a)); }
  // A zero vector stays zero.
  friend HWY_INLINE Vec3 normalize(Vec3 a) {
    const Tag d;
    const V l = length(a);
    return if_then_else(hn::Gt(l, hn::Zero(d)), a * hn::Div(hn::Set(d, 1), l), a);
  }
  // Lanes of the mask from a.
  template <class Mask>
  friend HWY_INLINE Vec3 if_then_else(Mask mask, Vec3 a, Vec3 b) {
    return {hn::IfThenElse(mask, a.x, b.x), hn::IfThenElse(mask, a.y, b.y),
            hn::IfThenElse(mask, a.z, b.z)};
  }
  template <class Mask>
  friend HWY_INLINE Vec3 negated_if(Mask mask, Vec3 a) {
    return if_then_else(mask, {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)}, a);
  }
};

// Of arrays by axis, lanes `at` and on; aligned.
template <class Tag, size_t kCount>
HWY_INLINE Vec3<Tag> load3(Tag d, const float (&from)[3][kCount], size_t at) {
  return {hn::Load(d, from[0] + at), hn::Load(d, from[1] + at), hn::Load(d, from[2] + at)};
}
template <class Tag, size_t kCount>
HWY_INLINE void store3(Tag d, Vec3<Tag> v, float (&to)[3][kCount], size_t at) {
  hn::Store(v.x, d, to[0] + at);
  hn::Store(v.y, d, to[1] + at);
  hn::Store(v.z, d, to[2] + at);
}
template <class Tag>
HWY_INLINE Vec3<Tag> same3(Tag d, const float (&v)[3]) {
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
