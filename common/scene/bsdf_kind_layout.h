// SPDX-License-Identifier: Apache-2.0
// How a surface scatters light: the BSDF part of a material, by its number in a scene's blocks.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera {

inline constexpr int kBsdfKindsMax = 15;

// See bsdf_kinds.inc.
enum class BsdfKind : uint8_t {
#define TESSERA_BSDF(kind, name, scattering, parameters) kind,
#include "common/scene/bsdf_kinds.inc"
};

}  // namespace tessera
