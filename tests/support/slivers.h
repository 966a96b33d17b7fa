// SPDX-License-Identifier: Apache-2.0
// Triangles whose corners nearly fall together, and full packets of rays that pass next to their
// edges: where a filter in float32 has least to go by.
//
// Threads. Pure functions of the choices.
#pragma once

#include <array>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/ray/packet_layout.h"
#include "tests/support/choices.h"

namespace tessera::test {

// A strip of triangles at one corner A, whose other corners are a few roundings apart each from the
// next, and some of which stand twice in the mesh; at scales of 1e-6 to 1e6, some of them 1e4 times
// their size from the world's origin, some in a plane of the world's axes or on a grid, where
// points of their plane are exact.
struct Slivers {
  float size = 1;
  Vec3f middle, a;
  std::vector<Vec3f> rim;  // B and C of the first triangle, C of the next, ...
  Mesh mesh;
};
Slivers make_slivers(Choices& any, unsigned triangle_count);

// Rays that are neighbours: aimed at points of the strip near to each other, from one origin or
// from several near to each other, some of them in the plane of a triangle or a few roundings from
// it. t_min is 0, above it, or where a hit may be.
struct NeighbourRays {
  std::array<core::SingleRay, core::kPacketRays> rays;
  bool is_fan = false;  // one origin and one t_min
};
NeighbourRays make_rays(Choices& any, const Slivers& slivers);

}  // namespace tessera::test
