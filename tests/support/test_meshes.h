// SPDX-License-Identifier: Apache-2.0
// Meshes for tests: closed ones, whose edges are shared by bits, and random triangles.
// Deterministic: a random one takes its seed.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"

namespace tessera::test {

// Unit cube [-1, 1]^3, 12 triangles, outward normals.
Mesh make_cube();
// Sphere of radius 1: an icosahedron subdivided `levels` times, 20 * 4^levels triangles.
Mesh make_icosphere(int levels);
// Torus around z, radii 1 and 0.4, 2 * around * across triangles.
Mesh make_torus(int around, int across);
// Triangles with a first corner in [-1, 1]^3 and edges up to `size`, not connected.
Mesh make_random_triangles(std::uint32_t count, float size, std::uint32_t seed);
// Height field over [-1, 1]^2 in y, 2 * n * n triangles.
Mesh make_terrain(int n, std::uint32_t seed);

// Moves and scales every vertex: p * scale + offset, in float32.
void place(Mesh& mesh, float scale, Vec3f offset);

// One mesh, one instance, one grey material.
Scene make_scene(Mesh mesh);
// Adds a parallelogram a, a + b, a + b + c, a + c; its normal is along b x c.
void add_quad(Mesh& mesh, Vec3f a, Vec3f b, Vec3f c, std::uint32_t material);

// A room with every feature: texture, smooth normals, all kinds of lights, an emitter, a sky,
// instances.
Scene make_full_scene();
// The room of make_full_scene() with every kind of surface program and BSDF.
Scene make_scene_of_all_materials();

}  // namespace tessera::test
