// SPDX-License-Identifier: Apache-2.0
// Surfaces that scatter light into directions that no light sample finds, whatever program has made
// their colours.
//
//   mirror   reflects `specular`, at every angle.
//   glass    exact Fresnel terms; one of reflection and refraction is chosen by chance. Radiance is
//            carried divided by the square of the index where the ray is (Nicodemus, "Radiance",
//            1963), which no interface changes: lamps, skies and cameras outside need no factor,
//            and only a lamp inside glass would have to be told that it is there.
//
// Glass is a kind of material, smooth and solid. It is also what a glossy material that passes
// light becomes where a ray meets its transparent part (transmission.h). Such glass may be
//   rough    the microfacets of glossy surfaces are interfaces (Walter et al., "Microfacet models
//            for refraction through rough surfaces", 2007), drawn by the pdf of visible normals.
//            Multiple scattering of a thin sheet goes where single scattering goes. That of a solid
//            is lost: at roughness 0.3 up to a tenth of the light, at 1 up to 0.6 on the way out
//            (lobes_test.cpp);
//   thin     a sheet without an inside: transmitted light keeps its direction, blurred as reflected
//            light is (KHR_materials_transmission).
//
// The other BSDFs scatter a packet at a time (slave/core/bsdf/bsdfs-inl.h). Paths run against the
// light; BSDFs are reciprocal, so viewer and light could change places.
//
// Results have the same bits on every processor and C library: arithmetic and square roots only.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"

namespace tessera::core {

struct SpecularSample {
  Vec3f direction;          // unit
  Vec3f weight;             // multiplies the radiance from there
  bool is_through = false;  // the direction leaves on the side away from the viewer
  float alpha = 0;          // width of the lobe that was sampled; 0: a single direction
};

// square: in [0, 1); smooth surfaces take x alone. Requires: `s` scatters into single directions;
// to_viewer is a unit vector on the side of both of its normals. The surface's weight is not looked
// at.
SpecularSample sample_specular(const Surface& s, Vec3f to_viewer, Vec2f square);

}  // namespace tessera::core
