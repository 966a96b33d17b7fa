// The surface that a ray has hit: geometry, then what its program fills in.
// Threads. Pure function.
#pragma once

#include <cstdint>

#include "slave/core/render/prepared_scene_impl.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

// What all points of a triangle have in common: neighbours on the picture mostly share it.
struct SurfaceTriangle {
  Vec3f a, edge_b, edge_c;  // A, B - A, C - A
  Vec3f normal;             // unit, along (B - A) x (C - A)
  float twice_area = 0;
  std::uint32_t instance = 0;
  const Mesh* mesh = nullptr;
  std::size_t local = 0;  // triangle of the mesh
  const Material* material = nullptr;
};
SurfaceTriangle surface_triangle(const PreparedScene::Impl& scene, std::uint32_t triangle);

// `to_surface`: direction of the ray that hit; `cone`: the ray's where it began; t: of the hit.
// Requires: u and v of its hit.
Surface surface_at(const PreparedScene::Impl& scene, const SurfaceTriangle& triangle, float u,
                   float v, Vec3f to_surface, RayCone cone = {}, float t = 0);

// The same in one. Requires: triangle < triangle count.
inline Surface surface_at(const PreparedScene::Impl& scene, std::uint32_t triangle, float u,
                          float v, Vec3f to_surface, RayCone cone = {}, float t = 0) {
  return surface_at(scene, surface_triangle(scene, triangle), u, v, to_surface, cone, t);
}

}  // namespace tessera::core
