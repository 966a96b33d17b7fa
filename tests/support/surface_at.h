// The surface at a place of a triangle, one at a time and in plain arithmetic: what the kernels have to
// agree with (slave/core/kernel/surface-inl.h), and what tests of textures and programs ask.
#pragma once

#include "slave/core/geometry/surface_offset.h"
#include "slave/core/kernel/kernel_table.h"
#include "slave/core/render/surface.h"

namespace tessera::test {

struct PlainPoint {
  core::SurfacePoint at;
  Vec3f normal;  // turned to the viewer
  bool is_front;
};

inline PlainPoint plain_point(const core::TriangleStore& triangles, std::uint32_t triangle, float u,
                              float v, Vec3f direction) {
  const Vec3f a = triangles.vertex(triangle, 0);
  const Vec3f b = triangles.vertex(triangle, 1) - a, c = triangles.vertex(triangle, 2) - a;
  const Vec3f outward = normalize(cross(b, c));
  const bool is_front = dot(outward, direction) < 0;
  const Vec3f normal = is_front ? outward : -outward;
  return {core::surface_point(a, b, c, normal, u, v), normal, is_front};
}

inline void apply_program(const core::SurfaceTriangle& triangle, const core::SurfaceHit& hit,
                          core::Surface& s) {
  core::SurfacePlaces places;
  core::add_place(triangle, hit, s, places);
  core::apply_surface_program(s.material->surface,
                              core::Noise(core::kernels_for(Isa::kScalar).noise), places);
}

// cone: at the surface.
inline core::Surface surface_at(const core::PreparedScene::Impl& scene, std::uint32_t triangle,
                                float u, float v, Vec3f direction, core::RayCone cone = {}) {
  const PlainPoint plain = plain_point(scene.triangles, triangle, u, v, direction);
  core::Surface s;
  s.point = plain.at.point;
  s.offset = plain.at.offset;
  s.normal = s.shading_normal = plain.normal;
  s.material = &core::material_of(scene, triangle);
  s.albedo = s.material->albedo;
  s.is_front = plain.is_front;
  if (s.is_front) s.emission = s.material->emission;
  const core::SurfaceTriangle shape = core::surface_triangle(scene, triangle);
  const core::SurfaceHit hit{u, v, direction, cone};
  core::enrich(scene, shape, hit, s);
  if (s.material->surface.kind != SurfaceKind::kConstant) apply_program(shape, hit, s);
  return s;
}

}  // namespace tessera::test
