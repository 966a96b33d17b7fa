// SPDX-License-Identifier: Apache-2.0
// The optional lobes of glossy surfaces, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/bsdf/bsdf_layout.h"
#include "slave/core/bsdf/layers_layout.h"

namespace tessera::core {

// Shape of all: [kBsdfPoints]. See SurfaceLobes; `specular` is in BsdfPoints.
struct alignas(64) LobePoints {
  float specular_f90[kBsdfPoints];
  float coat[kBsdfPoints], coat_roughness[kBsdfPoints], coat_normal[3][kBsdfPoints];
  float sheen[3][kBsdfPoints], sheen_roughness[kBsdfPoints];
  float stretch[kBsdfPoints], tangent[3][kBsdfPoints];
};

// Albedos of sheen (slave/core/bsdf/sheen_table.h) stand where those of microfacets have the scale.
struct LobeTables {
  AlbedoView facets, sheen;
};

}  // namespace tessera::core
