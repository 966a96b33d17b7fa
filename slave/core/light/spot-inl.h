// SPDX-License-Identifier: Apache-2.0
// How a spot light's strength falls off between its cones. T: float, or Floats.
// Threads. Pure functions.
#if defined(TESSERA_CORE_SPOT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SPOT_INL_H_
#undef TESSERA_CORE_SPOT_INL_H_
#else
#define TESSERA_CORE_SPOT_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// The falloff is 0 outside of the outer cone, 1 within the inner one, and between them the square
// of what is linear in the cosine (KHR_lights_punctual, "Inner and outer cone angles"). Where both
// cones are the same, it is 1 within them.
template <class T>
TESSERA_INLINE T spot_falloff(float cos_inner, float cos_outer, T cosine) {
  if (!(cos_inner > cos_outer)) return zero_unless(cosine >= cos_inner, set<T>(1));
  const T x = min(max((cosine - cos_outer) / (cos_inner - cos_outer), 0), 1);
  return x * x;
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
