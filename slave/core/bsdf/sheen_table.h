// SPDX-License-Identifier: Apache-2.0
// How much light white fibres send back, by angle and roughness: what their layer takes from those below
// (slave/core/bsdf/layered-inl.h). It is above 1 at grazing angles, where the model's fibres do not hide
// each other well enough: they are dimmed by as much there. 32 x 32 nodes, linear in roughness and in the root of the cosine, as
// those of microfacets are (albedo_table.h), and as exactly the same on every machine.
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

  // In the scale; the bias is 0, and there are no means.
  AlbedoView view() const { return {&nodes_[0][0].scale, nullptr, kNodes}; }

 private:
  SheenTable();

  std::array<std::array<SpecularAlbedo, kNodes>, kNodes> nodes_;  // [roughness][root of cosine]
};

// Of fibres of this roughness, at least kSheenRoughnessMin: the BSDF times pi. Cosines of the half vector,
// the viewer and the light, > 0.
float sheen_times_pi(float roughness, float z_half, float z_viewer, float z_light);

}  // namespace tessera::core
