// SPDX-License-Identifier: Apache-2.0
// The glossy BSDF of one surface in plain arithmetic. slave/core/bsdf/glossy-inl.h has to agree
// with it to the bit, and says what it computes and where that comes from.
#pragma once

#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/surface/surface.h"
#include "tests/support/bsdf_at.h"

namespace tessera::test {

// Requires: cosine and roughness in [0, 1].
inline core::SpecularAlbedo plain_albedo(float cosine, float roughness) {
  return core::albedo_at(core::AlbedoTable::shared().view(), cosine, roughness);
}

class PlainGlossy {
 public:
  struct Facets {
    Vec3f f0;              // reflected at normal incidence
    Vec3f several_albedo;  // of multiple scattering between facets
  };

  // Requires: s.bsdf is glossy; to_viewer is above its shading normal.
  PlainGlossy(const core::Surface& s, Vec3f to_viewer);

  BsdfValue evaluate(Vec3f to_light) const;
  BsdfSample sample(Vec2f square) const;

 private:
  // A unit vector in the frame of the shading normal.
  Vec3f local(Vec3f world) const;
  BsdfValue evaluate_local(Vec3f light) const;

  Vec3f normal_;
  core::Basis<float> basis_;
  Vec3f viewer_;  // local
  float roughness_, alpha_;
  Vec3f f0_;
  Vec3f several_;  // multiple scattering; times what a direction misses
  Vec3f several_albedo_;
  Facets dielectric_;
  Vec3f base_;          // diffuse part; times what the facets leave of a direction
  float facets_share_;  // share of samples
};

}  // namespace tessera::test
