#include "slave/core/render/scattered_rays.h"

#include <algorithm>
#include <limits>
#include <new>

#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;

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
  density[ray] = dot(out, s.shading_normal) * kInvPi;
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
  new (&surface) Surface(surface_at(scene, triangle, uv.x, uv.y, direction[i], cone[i], t));
  surface.weight = weight[i];
  return true;
}

Vec3f ScatteredRays::emission_met(const PreparedScene::Impl& scene, int i, std::uint32_t triangle,
                                  float t, const Surface& s, bool is_picked) const {
  const Emitter* emitter = scene.lights.emitter_of(triangle);
  // Light samples look at pictures of lamps as they are, not at their mip levels: so does this.
  if (emitter == nullptr)
    return s.material->emission_texture == kNoTexture ? weight[i] * s.emission : Vec3f{};
  const TriangleStore& triangles = scene.triangles;
  const Vec2f uv = barycentric(start[i], direction[i], triangles.vertex(triangle, 0),
                               triangles.vertex(triangle, 1), triangles.vertex(triangle, 2));
  const float chance = is_picked ? emitter->share : 1;
  const float light = chance / emitter->area * (t * t) / std::fabs(dot(s.normal, direction[i]));
  return weight[i] * scene.lights.emission_at(*emitter, uv.x, uv.y) *
         (density[i] / (density[i] + light));
}

Vec3f ScatteredRays::sky_met(const LightSet& lights, int i) const {
  if (!lights.sky_map) return weight[i] * lights.environment;
  if (!(density[i] > 0)) return {};
  const float share = density[i] / (density[i] + lights.sky_map->density(direction[i]));
  return weight[i] * lights.sky(direction[i]) * share;
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
