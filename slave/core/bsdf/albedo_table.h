// SPDX-License-Identifier: Apache-2.0
// How much light a single bounce on GGX microfacets reflects, by angle and roughness. The rest
// meets further facets, and the glossy BSDF puts it back (slave/core/bsdf/glossy-inl.h).
//
// The table is computed at the first use, summed in double over a fixed point set, with square
// roots only, so its bits are the same on every machine. It has 32 x 32 nodes and is linear in
// roughness and in the root of the cosine, so that nodes are dense at grazing angles. bsdf_test.cpp
// holds it against finer integration.
//
// Threads. Filled once by whoever asks first (a static), then read by any thread.
#pragma once

#include <array>
#include <cstdint>

#include "slave/core/bsdf/albedo_layout.h"

namespace tessera::core {

// The reflectance of Schlick's Fresnel term with f0 at normal incidence is f0 * scale + bias
// (Karis, "Real shading in Unreal Engine 4", 2013).
struct SpecularAlbedo {
  float scale = 0, bias = 0;
};

static_assert(sizeof(SpecularAlbedo) == 2 * sizeof(float));

// One lookup, computed as the kernels do (slave/core/bsdf/microfacet-inl.h); cosine and roughness
// in [0, 1].
SpecularAlbedo albedo_at(const AlbedoView& table, float cosine, float roughness);

// The table's value by so many points of the sample sequence: what it is interpolated from.
SpecularAlbedo albedo_by_points(float cosine, float alpha, std::uint32_t points);

class AlbedoTable {
 public:
  static constexpr int kNodes = 32;

  static const AlbedoTable& shared();

  // A view for lookups (slave/core/bsdf/microfacet-inl.h).
  AlbedoView view() const { return {&nodes_[0][0].scale, &means_[0].scale, kNodes}; }

 private:
  AlbedoTable();

  std::array<std::array<SpecularAlbedo, kNodes>, kNodes> nodes_;  // [roughness][root of cosine]
  std::array<SpecularAlbedo, kNodes> means_;                      // [roughness]
};

}  // namespace tessera::core
