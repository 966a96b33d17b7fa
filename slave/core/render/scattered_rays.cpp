#include "slave/core/render/scattered_rays.h"

#include <algorithm>
#include <limits>
#include <new>

#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

// How much a lobe widens what a pixel sees: a diffuse one by 0.2 for each unit of length, so that
// textures are looked up in levels that are at hand, and narrower lobes by their alpha's share.
constexpr float kDiffuseSpread = 0.2f;

}  // namespace

void ScatteredRays::clear() {
  count = 0;
  packet_.habit = {};
  std::fill_n(packet_.t_min, kPacketRays, 0.0f);
  std::fill_n(packet_.t_max, kPacketRays, std::numeric_limits<float>::infinity());
}

// Diffuse surfaces take the short way; it is that of sample().
void ScatteredRays::add(const SurfaceBatch& batch, int i, Vec2f square, std::uint32_t ray_key) {
  const Surface& s = batch.surface[i];
  if (s.bsdf != BsdfKind::kDiffuse) return add_sample(batch, i, square, ray_key);
  const Vec3f reflected = s.albedo * s.weight;
  if (is_black(reflected)) return;
  const Vec3f out = cosine_direction(s.shading_normal, square);
  if (!(dot(out, s.normal) > 0)) return;  // below the surface, by an interpolated normal
  const int ray = push(batch, i, ray_key);
  start[ray] = s.point + s.normal * s.offset;
  direction[ray] = out;
  weight[ray] = reflected;
  density[ray] = 0;
  cone[ray] = s.cone.widened(kDiffuseSpread);
}

void ScatteredRays::add_sample(const SurfaceBatch& batch, int i, Vec2f square,
                               std::uint32_t ray_key) {
  const Surface& s = batch.surface[i];
  const BsdfSample out = sample(s, s.to_viewer, square);
  if (is_black(out.weight * s.weight)) return;
  const Vec3f outward = s.normal * (out.is_through ? -1.0f : 1.0f);
  if (!(dot(out.direction, outward) > 0)) return;
  const int ray = push(batch, i, ray_key);
  start[ray] = s.point + outward * s.offset;
  direction[ray] = out.direction;
  weight[ray] = out.weight * s.weight;
  density[ray] = out.density;
  cone[ray] = out.is_delta ? s.cone : s.cone.widened(kDiffuseSpread * s.roughness * s.roughness);
}

int ScatteredRays::push(const SurfaceBatch& batch, int i, std::uint32_t ray_key) {
  origin[count] = i;
  pixel[count] = batch.pixel[i];
  key[count] = ray_key;
  return count++;
}

bool ScatteredRays::meet(const PreparedScene::Impl& scene, int i, std::uint32_t triangle, float t,
                         Surface& surface) const {
  if (triangle == kNoPrimitive) return false;
  const TriangleStore& triangles = scene.triangles;
  const Vec2f uv = barycentric(start[i], direction[i], triangles.vertex(triangle, 0),
                               triangles.vertex(triangle, 1), triangles.vertex(triangle, 2));
  // In its place, without a copy: this is the path of every bounce.
  new (&surface)
      Surface(surface_at(scene, triangle, uv.x, uv.y, direction[i], cone[i].advanced(t)));
  surface.weight = weight[i];
  return true;
}

Vec3f ScatteredRays::emission_met(const PreparedScene::Impl& scene, int i, std::uint32_t triangle,
                                  float t, const Surface& s, bool is_picked) const {
  const TriangleStore& triangles = scene.triangles;
  const Vec3f a = triangles.vertex(triangle, 0);
  const float area =
      length(cross(triangles.vertex(triangle, 1) - a, triangles.vertex(triangle, 2) - a)) / 2;
  const float light = scene.lights.density_by_area(s.emission, area, is_picked) * (t * t) /
                      std::fabs(dot(s.normal, direction[i]));
  return weight[i] * s.emission * (density[i] / (density[i] + light));
}

void ScatteredRays::trace(const SceneTracer& tracer, const int* rays, int n, PacketHits& hits) {
  packet_.active = ~std::uint64_t{0} >> (kPacketRays - n);
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a < 3; ++a) {
      packet_.origin[a][i] = start[rays[i]][a];
      packet_.direction[a][i] = direction[rays[i]][a];
    }
  }
  tracer.closest(packet_, hits);
}

}  // namespace tessera::core
