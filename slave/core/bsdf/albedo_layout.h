// SPDX-License-Identifier: Apache-2.0
// The table of albedos of microfacets, as the kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

// View of an AlbedoTable or a SheenTable (slave/core/bsdf/albedo_table.h, sheen_table.h): pairs of
// scale and bias.
struct AlbedoView {
  const float* nodes;  // [roughness][root of cosine][2]
  const float* means;  // [roughness][2]
  int32_t node_count;  // along either axis
};

}  // namespace tessera::core
