#include "slave/core/render/direct_light.h"

#include <bit>
#include <cmath>
#include <limits>

#include "slave/core/geometry/surface_offset.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;

// 0 below the outer cone, 1 within the inner, a cubic in the cosine between.
float spot_falloff(const Light& light, float cosine) {
  if (!(cosine > light.cos_outer)) return 0;
  if (cosine >= light.cos_inner) return 1;
  const float x = (cosine - light.cos_outer) / (light.cos_inner - light.cos_outer);
  return x * x * (3 - 2 * x);
}

// The cosine at the surface, zero where either normal says that the light is behind it: an
// interpolated normal may not let light through the surface.
float cosine_at(const Surface& s, Vec3f to_light) {
  if (!(dot(s.normal, to_light) > 0)) return 0;
  const float c = dot(s.shading_normal, to_light);
  return c > 0 ? c : 0;
}

bool is_usable(Vec3f c) { return is_finite(c) && (c.x > 0 || c.y > 0 || c.z > 0); }

}  // namespace

void DirectLight::begin(const PreparedScene::Impl& scene, const KernelTable& kernels,
                        int light_samples) {
  scene_ = &scene;
  kernels_ = &kernels;
  view_ = scene.view();
  light_samples_ = light_samples;
}

// A shadow ray to `target` starts on the viewer's side of the surface; t = 1 is the target.
void DirectLight::set_ray(int lane, const Surface& surface, Vec3f target, float t_max) {
  const Vec3f start = surface.point + surface.normal * surface.offset;
  const Vec3f direction = target - start;
  for (int a = 0; a < 3; ++a) {
    rays_.origin[a][lane] = start[a];
    rays_.direction[a][lane] = direction[a];
  }
  rays_.t_min[lane] = 0;
  rays_.t_max[lane] = t_max;
  rays_.active |= 1u << lane;
}

std::uint64_t DirectLight::trace(Vec3f* radiance) {
  if (rays_.active == 0) return 0;
  const std::uint32_t seen = rays_.active & ~kernels_->trace_occluded(view_, rays_);
  for (int lane = 0; lane < kBundleRays; ++lane) {
    if (seen >> lane & 1u) radiance[lane] = radiance[lane] + contribution_[lane];
  }
  return static_cast<std::uint64_t>(std::popcount(rays_.active));
}

std::uint64_t DirectLight::add(const SurfaceBlock& block, Vec3f* radiance) {
  std::uint64_t rays = 0;
  for (const Light& light : scene_->lights.lights) rays += add_light(block, light, radiance);
  if (!scene_->lights.emitters.empty()) rays += add_emitters(block, radiance);
  return rays;
}

std::uint64_t DirectLight::add_light(const SurfaceBlock& block, const Light& light,
                                     Vec3f* radiance) {
  rays_.active = 0;
  for (int lane = 0; lane < kBundleRays; ++lane) {
    if ((block.hit >> lane & 1u) == 0) continue;
    const Surface& s = block.surface[lane];
    if (light.kind == LightKind::kDirectional) {
      const Vec3f to_light = -light.direction;
      contribution_[lane] = s.albedo * light.intensity * (kInvPi * cosine_at(s, to_light));
      if (!is_usable(contribution_[lane])) continue;
      const Vec3f start = s.point + s.normal * s.offset;
      set_ray(lane, s, start, std::numeric_limits<float>::infinity());
      for (int a = 0; a < 3; ++a) rays_.direction[a][lane] = to_light[a];
      continue;
    }
    const Vec3f away = light.position - s.point;
    const float distance2 = dot(away, away);
    const Vec3f to_light = away * (1 / std::sqrt(distance2));
    float strength = cosine_at(s, to_light) / distance2;
    if (light.kind == LightKind::kSpot)
      strength *= spot_falloff(light, -dot(light.direction, to_light));
    contribution_[lane] = s.albedo * light.intensity * (kInvPi * strength);
    if (!is_usable(contribution_[lane])) continue;
    // The direction is rounded once per component and t has the error of the triangle test, 16 u of
    // the distance for geometry about as far away as the light: what lies closer to the light is
    // its housing.
    set_ray(lane, s, light.position, 1 - 17 * kUnitRoundoff);
  }
  return trace(radiance);
}

// One sample of one emitter for one lane; leaves the lane inactive when nothing arrives.
void DirectLight::aim(const SurfaceBlock& block, int lane, const Emitter& emitter, Vec2f sample,
                      float weight) {
  // Uniform on the triangle (Osada et al., "Shape distributions", 2002, section 4.2); keeps strata.
  const float root = std::sqrt(sample.x);
  const SurfacePoint at = surface_point(emitter.a, emitter.edge_b, emitter.edge_c, emitter.normal,
                                        root * (1 - sample.y), root * sample.y);
  const Surface& s = block.surface[lane];
  const Vec3f away = at.point - s.point;
  const float distance2 = dot(away, away);
  const float distance = std::sqrt(distance2);
  const Vec3f to_light = away * (1 / distance);
  const float cosine_light = -dot(emitter.normal, to_light);
  if (!(cosine_light > 0)) return;  // one-sided
  const float strength = cosine_at(s, to_light) * cosine_light * emitter.area / distance2;
  contribution_[lane] = s.albedo * emitter.emission * (kInvPi * strength * weight);
  if (!is_usable(contribution_[lane])) return;
  // The ray ends at a point moved off the emitter as its start is moved off the surface, so t <= 1
  // cannot reach the emitter itself. The direction rounds once per component: gamma(2) of its
  // length.
  const float off = at.offset + gamma(2) * distance;
  set_ray(lane, s, at.point + emitter.normal * off, 1);
}

std::uint64_t DirectLight::add_emitters(const SurfaceBlock& block, Vec3f* radiance) {
  const LightSet& lights = scene_->lights;
  const bool is_shared_out = lights.is_shared_out();
  const std::uint32_t emitter_rounds =
      is_shared_out ? 1u : static_cast<std::uint32_t>(lights.emitters.size());
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  std::uint64_t rays = 0;
  for (std::uint32_t e = 0; e < emitter_rounds; ++e) {
    for (std::uint32_t j = 0; j < samples; ++j) {
      rays_.active = 0;
      const std::uint32_t index = block.sample_index * samples + j;
      for (int lane = 0; lane < kBundleRays; ++lane) {
        if ((block.hit >> lane & 1u) == 0) continue;
        const std::uint32_t key = hash_combine(block.key[lane], 2 * e);
        const Emitter& emitter =
            is_shared_out ? lights.pick(sample_1d(hash_combine(block.key[lane], 1), index))
                          : lights.emitters[e];
        const float weight = 1 / (static_cast<float>(samples) * emitter.share);
        aim(block, lane, emitter, sample_2d(key, index), weight);
      }
      rays += trace(radiance);
    }
  }
  return rays;
}

}  // namespace tessera::core
