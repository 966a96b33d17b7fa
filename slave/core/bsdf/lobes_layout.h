// SPDX-License-Identifier: Apache-2.0
// The optional lobes of glossy surfaces, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include "common/scene/bsdf_kind_layout.h"
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

// The tables of albedos. Those of sheen (slave/core/bsdf/sheen_table.h) are stored in the scale.
struct LobeTables {
  AlbedoView facets, sheen;
  CoatView coat;
};

// The kernels of one slot: `sample` draws directions to the light, `evaluate` takes given ones.
// `lobes` is null except in kLayeredSlot. Both kernels null: surfaces of this slot scatter into
// single directions. `evaluate` alone null: they are diffuse.
struct BsdfKernel {
  void (*sample)(const LobeTables& tables, const LobePoints* lobes, BsdfPoints& points);
  void (*evaluate)(const LobeTables& tables, const LobePoints* lobes, BsdfPoints& points);
};

// Slots: the kinds of BSDF, and behind them the glossy one with optional lobes.
inline constexpr int kLayeredSlot = kBsdfKindsMax;
inline constexpr int kBsdfSlots = kBsdfKindsMax + 1;

struct BsdfKernels {
  BsdfKernel of[kBsdfSlots];
};

}  // namespace tessera::core
