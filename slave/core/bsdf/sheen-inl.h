// SPDX-License-Identifier: Apache-2.0
// The sheen of fibres that stand up (Estevez and Kulla, "Production friendly microfacet sheen
// BRDF", 2017) with the shadowing of cloth (Neubelt and Pettineo, "Crafting a next-gen material
// pipeline for The Order: 1886", 2013). T: float, or Floats.
// Threads. Pure functions.
#if defined(TESSERA_CORE_SHEEN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SHEEN_INL_H_
#undef TESSERA_CORE_SHEEN_INL_H_
#else
#define TESSERA_CORE_SHEEN_INL_H_
#endif

#include "slave/core/simd/power-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// The BSDF of white fibres, times pi. exponent: 1 over the square of the roughness; z_half,
// z_viewer, z_light: cosines to the normal.
template <class T>
TESSERA_INLINE T fibres_times_pi(T exponent, T z_half, T z_viewer, T z_light) {
  const T fibres = power(max(1 - z_half * z_half, 0), 0.5f * exponent);
  return (2 + exponent) * fibres / (8 * (z_light + z_viewer - z_light * z_viewer));
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
