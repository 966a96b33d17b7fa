// SPDX-License-Identifier: Apache-2.0
// How much light white fibres reflect, by angle and roughness: the share that their layer takes
// from the layers below (slave/core/bsdf/layered-inl.h). That albedo is above 1 at grazing angles,
// where the model's fibres do not shadow each other well enough; fibres are dimmed by as much
// there. The table has 32 x 32 nodes, is linear in roughness and in the root of the cosine, and has
// the same bits on every machine, like that of microfacets (albedo_table.h).
//
// Threads. Filled once by whoever asks first (a static), then read by any thread.
#pragma once

#include <array>

#include "slave/core/bsdf/albedo_table.h"

namespace tessera::core {

class SheenTable {
 public:
  static constexpr int kNodes = 32;

  static const SheenTable& shared();

  // The albedos are in the scale; the bias is 0, and there are no means.
  AlbedoView view() const { return {&nodes_[0][0].scale, nullptr, kNodes}; }

 private:
  SheenTable();

  std::array<std::array<SpecularAlbedo, kNodes>, kNodes> nodes_;  // [roughness][root of cosine]
};

// The BSDF of white fibres, times pi. roughness: at least kSheenRoughnessMin. z_half, z_viewer,
// z_light: cosines to the normal, >= 0; that of the light > 0.
float sheen_times_pi(float roughness, float z_half, float z_viewer, float z_light);

}  // namespace tessera::core
