// SPDX-License-Identifier: Apache-2.0
// Vectors whose components are registers: the text of common/math/vec3_text.h, so that every
// operation has the roundings of Vec3f.
// Threads. Pure functions.
#if defined(TESSERA_CORE_VEC3_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_VEC3_INL_H_
#undef TESSERA_CORE_VEC3_INL_H_
#else
#define TESSERA_CORE_VEC3_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

#ifndef TESSERA_PLAIN_TEXT  // whose vectors are those of common/math/vec3.h

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#define TESSERA_VEC3_INLINE HWY_INLINE
#include "common/math/vec3_text.h"
#undef TESSERA_VEC3_INLINE

// Zero in the lanes that the mask leaves out.
template <class M, class V>
HWY_INLINE Vec3<V> zero_unless(M mask, Vec3<V> a) {
  return {zero_unless(mask, a.x), zero_unless(mask, a.y), zero_unless(mask, a.z)};
}

// Loads and stores vectors in arrays by axis, lanes `at` and on; aligned.
template <class V, size_t kCount>
HWY_INLINE Vec3<V> load3(const LaneOf<V> (&from)[3][kCount], size_t at) {
  return {load<V>(from[0] + at), load<V>(from[1] + at), load<V>(from[2] + at)};
}
template <class V, size_t kCount>
HWY_INLINE void store3(Vec3<V> v, LaneOf<V> (&to)[3][kCount], size_t at) {
  store(v.x, to[0] + at);
  store(v.y, to[1] + at);
  store(v.z, to[2] + at);
}
template <class V>
HWY_INLINE Vec3<V> same3(const LaneOf<V> (&v)[3]) {
  return {set<V>(v[0]), set<V>(v[1]), set<V>(v[2])};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
