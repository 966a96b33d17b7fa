// The surface that a ray has hit: geometry, then what its program fills in.
// Threads. Pure functions; an object serves one thread.
#pragma once

#include <cstdint>

#include "slave/core/geometry/barycentric.h"
#include "slave/core/kernel/packet_layout.h"
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

// Surfaces that rays from one origin meet, one after the other.
class SurfacesSeen {
 public:
  // spread: of a ray's cone, which begins at the origin without width. Requires: scene outlives it.
  SurfacesSeen(const PreparedScene::Impl& scene, Vec3f origin, float spread)
      : scene_(scene), origin_(origin), spread_(spread), barycentric_(origin, {}, {}, {}) {}

  // Requires: the ray meets the triangle, at t.
  Surface at(std::uint32_t triangle, Vec3f direction, float t) {
    if (triangle != known_) {
      const TriangleStore& store = scene_.triangles;
      known_ = triangle;
      shape_ = surface_triangle(scene_, triangle);
      barycentric_ = {origin_, store.vertex(triangle, 0), store.vertex(triangle, 1),
                      store.vertex(triangle, 2)};
    }
    const Vec2f uv = barycentric_.of(direction);
    return surface_at(scene_, shape_, uv.x, uv.y, direction, {0, spread_}, t);
  }

 private:
  const PreparedScene::Impl& scene_;
  const Vec3f origin_;
  const float spread_;
  std::uint32_t known_ = kNoPrimitive;
  SurfaceTriangle shape_;
  Barycentric barycentric_;
};

}  // namespace tessera::core
