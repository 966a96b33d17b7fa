// SPDX-License-Identifier: Apache-2.0
// Surfaces that scatter light into directions that no sample of a light finds, whatever program has made
// their colours.
//
//   mirror   reflects `specular`, at every angle.
//   glass    exact Fresnel terms; one of reflection and refraction is chosen by chance. Radiance is
//            carried divided by the square of the index where the ray is (Nicodemus, "Radiance", 1963),
//            which no interface changes: lamps, skies and cameras outside need no factor, and only a lamp
//            inside glass would have to be told that it is there.
//
// Glass is a kind of material, smooth and solid; or what a glossy one that passes light turns out to be
// where a ray meets it (transmission.h). That may be
//   rough    the microfacets of glossy surfaces are interfaces (Walter et al., "Microfacet models for
//            refraction through rough surfaces", 2007), drawn by the pdf of visible normals. Of a
//            thin one what meets them more than once goes where the rest goes; of a solid one it is lost: of roughness 0.3 up to a
//            tenth, of 1 up to 0.6 on the way out (lobes_test.cpp);
//   thin     a sheet without inside: what it passes goes on in its direction, blurred as what it reflects
//            is (KHR_materials_transmission).
//
// The others scatter a packet at a time (slave/core/bsdf/bsdfs-inl.h). Paths go
// against the light; BSDFs are reciprocal, so the names could be exchanged.
//
// The same bits on every processor and C library: arithmetic and square roots only.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"

namespace tessera::core {

struct SpecularSample {
  Vec3f direction;          // unit
  Vec3f weight;             // of what is met there
  bool is_through = false;  // leaves on the side that the viewer is not on
  float alpha = 0;          // width of the lobe that it was taken from
};

// square: in [0, 1); of smooth surfaces x alone. Requires: `s` scatters into single directions; to_viewer is a unit
// vector on the side of both of its normals. The surface's weight is not looked at.
SpecularSample sample_specular(const Surface& s, Vec3f to_viewer, Vec2f square);

}  // namespace tessera::core
