// Surfaces that scatter light into single directions, whatever program has made their colours.
//
//   mirror   reflects `specular`, at every angle.
//   glass    smooth, exact Fresnel terms; one of reflection and refraction is chosen by chance.
//            Radiance is carried divided by the square of the index where the ray is (Nicodemus,
//            "Radiance", 1963), which no interface changes: lamps, skies and cameras outside need no
//            factor, and only a lamp inside glass would have to be told that it is there.
//
// The others, diffuse and glossy, scatter a packet at a time (slave/core/kernel/glossy-inl.h). Paths go
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
};

// 0 <= choice < 1. Requires: `s` is a mirror or glass; to_viewer is a unit vector on the side of both
// of its normals. The surface's weight is not looked at.
SpecularSample sample_specular(const Surface& s, Vec3f to_viewer, float choice);

}  // namespace tessera::core
