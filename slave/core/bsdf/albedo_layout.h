// SPDX-License-Identifier: Apache-2.0
// The tables of albedos of microfacets and of varnish, as the kernels see them.
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

// Means over all directions, cosine-weighted. A is the albedo of varnish of weight 1, scale and
// bias are those of the facets below, missing is 1 minus both.
struct CoatMeans {
  float albedo;                               // A
  float of_missing, of_scale, of_bias;        // A times each
  float share_of_missing;                     // that of A times missing over that of missing
  float regained_of_scale, regained_of_bias;  // what facets lose to varnish, see CoatTable
};

// View of a CoatTable (slave/core/bsdf/coat_table.h).
struct CoatView {
  AlbedoView facets;       // finer than that of plain surfaces, for those under it and its own
  const float* regained;   // [roughness below][of the varnish][root of cosine][scale, bias]
  const CoatMeans* means;  // [roughness below][of the varnish]
  int32_t base_count, coat_count, cosine_count;  // of nodes
};

}  // namespace tessera::core
