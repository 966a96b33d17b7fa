// SPDX-License-Identifier: Apache-2.0
// The surface at a place of a triangle, as the renderer makes it, for tests that have no ray.
// Threads. Pure functions.
#pragma once

#include "slave/core/scene/met_surfaces.h"
#include "slave/core/simd/isa_support.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::test {

// direction: of a ray to that place, of any length; where it is edge-on, u and v of the surface are
// far from exact. cone: the ray cone at the surface.
inline core::Surface surface_at(const core::PreparedScene::Impl& scene, std::uint32_t triangle,
                                float u, float v, Vec3f direction, core::RayCone cone = {},
                                Isa isa = widest_isa(core::cpu_isas() & core::compiled_isas())) {
  const auto corner = [&](int k) { return scene.triangles.vertex(triangle, k); };
  const Vec3f point = corner(0) * (1 - u - v) + corner(1) * u + corner(2) * v;
  core::RayPacket rays{};
  core::PacketHits hits;
  std::fill_n(hits.primitive, core::kPacketRays, core::kNoPrimitive);
  constexpr int kRay = 37;
  hits.primitive[kRay] = triangle;
  hits.t[kRay] = 1;
  for (int a = 0; a < 3; ++a) {
    rays.origin[a][kRay] = point[a] - direction[a];
    rays.direction[a][kRay] = direction[a];
  }
  core::MetSurfaces::Memory memory;
  core::MetSurfaces met(scene, core::kernels_for(isa), memory);
  met.find(rays, hits);
  core::RayCone cones[core::kPacketRays];
  cones[kRay] = {cone.width - cone.spread * met.points().distance[kRay], cone.spread};
  core::Surface surface;
  core::Surface* to[core::kPacketRays] = {};
  to[kRay] = &surface;
  met.make(rays, hits, met.points().met, scene.features.needs_cones() ? cones : nullptr, to);
  return surface;
}

// The surface that a ray through `at` meets first, from one before it.
inline core::Surface surface_towards(const core::PreparedScene::Impl& scene, Vec3f at,
                                     Vec3f direction) {
  const core::KernelTable& kernels =
      core::kernels_for(widest_isa(core::cpu_isas() & core::compiled_isas()));
  core::RayPacket rays{};
  rays.active = 1;
  rays.t_max[0] = 2;
  for (int a = 0; a < 3; ++a) {
    rays.origin[a][0] = at[a] - direction[a];
    rays.direction[a][0] = direction[a];
  }
  core::PacketHits hits;
  core::SceneTracer(scene.index, kernels).closest(rays, hits);
  core::MetSurfaces::Memory memory;
  core::MetSurfaces met(scene, kernels, memory);
  met.find(rays, hits);
  core::RayCone cones[core::kPacketRays];
  core::Surface surface;
  core::Surface* to[core::kPacketRays] = {&surface};
  met.make(rays, hits, met.points().met, cones, to);
  return surface;
}

}  // namespace tessera::test
