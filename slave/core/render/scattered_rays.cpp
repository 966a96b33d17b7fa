#include "slave/core/render/scattered_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;

// How much a lobe widens what a pixel sees: a diffuse one by 0.2 for each unit of length, so that
// textures are looked up in levels that are at hand, and narrower lobes by their alpha's share.
constexpr float kDiffuseSpread = 0.2f;

}  // namespace

void ScatteredRays::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer) {
  scene_ = &scene;
  tracer_ = &tracer;
  met_.begin(scene, tracer.kernels());
  sky_.begin(scene.lights, tracer.kernels());
}

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

std::uint64_t ScatteredRays::trace(const int* rays, int n) {
  packet_.active = bits_below(n);
  for (int i = 0; i < n; ++i) {
    number_[i] = rays[i];
    for (int a = 0; a < 3; ++a) {
      packet_.origin[a][i] = start[rays[i]][a];
      packet_.direction[a][i] = direction[rays[i]][a];
    }
  }
  tracer_->closest(packet_, hits_);
  met_.find(packet_, hits_);
  return met_.points().met;
}

void ScatteredRays::meet(std::uint64_t met, Surface* const* to) {
  RayCone cones[kPacketRays];
  const bool has_cones = scene_->features.needs_cones();
  for (std::uint64_t left = has_cones ? met : 0; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    cones[i] = cone[number_[i]];
  }
  met_.make(met, has_cones ? cones : nullptr, to);
  for (; met != 0; met &= met - 1) {
    const int i = std::countr_zero(met);
    to[i]->weight = weight[number_[i]];
  }
}

Vec3f ScatteredRays::emission_met(int i, const Surface& s, bool is_picked) const {
  const int ray = number_[i];
  const Emitter* emitter = scene_->lights.emitter_of(met_.triangle(i));
  // Light samples look at pictures of lamps as they are, not at their mip levels: so does this.
  if (emitter == nullptr)
    return s.material->emission_texture == kNoTexture ? weight[ray] * s.emission : Vec3f{};
  const float chance = is_picked ? emitter->share : 1, t = hits_.t[i];
  const float light = chance / emitter->area * (t * t) / std::fabs(dot(s.normal, direction[ray]));
  const PacketPoints& at = met_.points();
  return weight[ray] * scene_->lights.emission_at(*emitter, at.u[i], at.v[i]) *
         (density[ray] / (density[ray] + light));
}

Vec3f ScatteredRays::sky_met(int i) const {
  const int ray = number_[i];
  const Vec3f light = weight[ray] * sky_.radiance(i);
  if (!sky_.has_map() || !(density[ray] > 0)) return light;
  return light * (density[ray] / (density[ray] + sky_.density(i)));
}

}  // namespace tessera::core
