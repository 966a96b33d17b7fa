// A rough dielectric or metal, seen from one direction: glTF 2.0's metallic-roughness (appendix B),
// with all energy kept. Three parts:
//   - GGX facets that reflect once, Schlick's Fresnel term;
//   - light that they reflect more than once: what the first part misses of a white surface, spread
//     so that the sum is reciprocal (Kulla and Conty, "Revisiting physically based shading at
//     Imageworks", 2017), coloured by the Fresnel terms that it meets (Fdez-Aguera, "A
//     multiple-scattering microfacet model for real-time image based lighting", JCGT 8(1), 2019);
//   - a diffuse base of what both leave, in and out, in the same form.
// Between dielectric and metal it is so much of the one and so much of the other.
// A white metal and a white dielectric reflect everything, whatever angle and roughness, but for the
// table's error (albedo_table.h; bsdf_test.cpp: below 1 %).
//
// Threads. Plain values, made and used by one worker.
#pragma once

#include "slave/core/bsdf/bsdf.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {

class GlossyLobes {
 public:
  struct Facets {
    Vec3f f0;              // reflected at normal incidence
    Vec3f several_albedo;  // of light that stays among them for a while
  };

  // Requires: s.bsdf is glossy; to_viewer is above its shading normal.
  GlossyLobes(const Surface& s, Vec3f to_viewer);

  BsdfValue evaluate(Vec3f to_light) const;
  BsdfSample sample(Vec2f square) const;

 private:
  // Unit, in the frame of the shading normal.
  Vec3f local(Vec3f world) const;
  BsdfValue evaluate_local(Vec3f light) const;

  Vec3f normal_;
  Basis basis_;
  Vec3f viewer_;  // local
  float roughness_, alpha_;
  Vec3f f0_;
  Vec3f several_;  // of light met more than once: times what a direction misses
  Vec3f several_albedo_;
  Facets dielectric_;
  Vec3f base_;          // of the diffuse part: times what the facets leave of a direction
  float facets_share_;  // of samples
};

}  // namespace tessera::core
