// How surfaces scatter light, whatever program has made their colours.
//
//   diffuse  Lambert.
//   glossy   glTF's metallic-roughness (glossy.h): keeps all light but what the albedo takes.
//   mirror   reflects `specular`, at every angle.
//   glass    smooth, exact Fresnel terms; one of reflection and refraction is chosen by chance.
//            Radiance is carried divided by the square of the index where the ray is (Nicodemus,
//            "Radiance", 1963), which no interface changes: lamps, skies and cameras outside need no
//            factor, and only a lamp inside glass would have to be told that it is there.
//
// Paths go against the light; BSDFs are reciprocal, so the names could be exchanged.
//
// The same bits on every processor and C library: arithmetic and square roots only.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"

namespace tessera::core {

struct BsdfValue {
  Vec3f times_pi;     // of the BSDF: a diffuse surface's is its albedo
  float density = 0;  // with which sample() takes this direction, by solid angle
};

struct BsdfSample {
  Vec3f direction;    // unit
  Vec3f weight;       // BSDF times cosine over density; zero: nothing comes from there
  float density = 0;  // by solid angle; 0 where it is the only direction (mirror, glass)
  bool is_delta = false;
  bool is_through = false;  // leaves on the side that the viewer is not on
};

// All: to_viewer and to_light are unit vectors, to_viewer on the side of both normals of `s`.
// The surface's weight is not looked at. What lies behind either normal is the caller's to leave
// out: evaluate() is about shading normals.

// Zero for mirror and glass. Requires: to_light is above the shading normal.
BsdfValue evaluate(const Surface& s, Vec3f to_viewer, Vec3f to_light);

// `square`: in [0, 1)^2.
BsdfSample sample(const Surface& s, Vec3f to_viewer, Vec2f square);

}  // namespace tessera::core
