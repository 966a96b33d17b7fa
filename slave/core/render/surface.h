// The surface that a ray has hit beyond its plain geometry: normals of vertices, textures, what
// scattering needs to know, and where its program is to look. Scenes of plain diffuse triangles never
// come here (met_surfaces.h).
//
// Threads. Pure functions.
#pragma once

#include <cstdint>

#include "slave/core/render/prepared_scene_impl.h"
#include "slave/core/surface/programs.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

const Material& material_of(const PreparedScene::Impl& scene, std::uint32_t triangle);

// What all points of a triangle have in common: neighbours on the picture mostly share it.
struct SurfaceTriangle {
  std::uint32_t number = 0xffffffffu;
  Vec3f edge_b, edge_c;  // B - A, C - A, world units
  float twice_area = 0;
  std::uint32_t instance = 0;
  const Mesh* mesh = nullptr;
  std::size_t local = 0;  // triangle of the mesh
  // Of the mesh, before its transform: for programs.
  Vec3f own_a, own_b, own_c;  // A, B - A, C - A
  Vec3f own_normal;           // along (B - A) x (C - A)
  float shrunk = 0;           // lengths there to lengths in the world, about
};
SurfaceTriangle surface_triangle(const PreparedScene::Impl& scene, std::uint32_t triangle);

// A hit of a ray.
struct SurfaceHit {
  float u, v;
  Vec3f direction;  // of the ray
  RayCone cone;     // here
};

// Requires: `s` is as plain geometry makes it.
void enrich(const PreparedScene::Impl& scene, const SurfaceTriangle& triangle,
            const SurfaceHit& hit, Surface& s);

// Adds a place of `s` for its program. Requires: places.count < kPlacesMax.
void add_place(const SurfaceTriangle& triangle, const SurfaceHit& hit, Surface& s,
               SurfacePlaces& places);

}  // namespace tessera::core
