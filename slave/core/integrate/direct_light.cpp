// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/direct_light.h"

#include <algorithm>
#include <limits>

#include "common/math/rounding.h"
#include "slave/core/integrate/light_samples.h"

namespace tessera::core {
namespace {

// A reported t is off by 3 roundings (plane-inl.h): what lies beyond 1 for certain is not hit.
constexpr float kEnd = 1 - 4 * kUnitRoundoff;

}  // namespace

// Of the surfaces of a batch towards one light sample each.
struct DirectLight::ShadowRays {
  LightSamples samples;
  RayGroups groups;
  int surface[kBatchMax];  // of a ray of `groups`
  float t_max = 1;

  void add(int s, Vec3f seen_from_light) {
    surface[groups.count()] = s;
    groups.add(seen_from_light);
  }
};

DirectLight::DirectLight() : rays_(std::make_unique<ShadowRays>()) {}
DirectLight::~DirectLight() = default;

void DirectLight::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                        int light_samples, Kind kind, const std::atomic<bool>* is_cancelled) {
  scene_ = &scene;
  tracer_ = &tracer;
  light_samples_ = kind == Kind::kWhole ? light_samples : 1;
  picks_emitters_ = kind == Kind::kPartOfPath || scene.lights.is_shared_out();
  samples_environment_ =
      scene.lights.has_environment && (kind == Kind::kWhole || scene.lights.sky_map);
  samples_glossy_ = kind == Kind::kWhole && scene.features.has_glossy &&
                    (scene.lights.has_environment || !scene.lights.emitters.empty());
  is_cancelled_ = is_cancelled;
  rays_->samples.begin(scene, tracer.kernels(),
                       {light_samples_, kind == Kind::kWhole, picks_emitters_});
  if (samples_glossy_) glossy_.begin(scene, tracer, light_samples, is_cancelled);
}

std::uint64_t DirectLight::add(const SurfaceBatch& batch, Vec3f* radiance) {
  std::uint64_t rays = 0;
  for (const Light& light : scene_->lights.lights) {
    if (is_over()) return rays;
    rays += light.kind == LightKind::kDirectional ? add_directional(batch, light, radiance)
                                                  : add_point(batch, light, radiance);
  }
  if (!scene_->lights.emitters.empty()) rays += add_emitters(batch, radiance);
  if (samples_environment_) rays += add_environment(batch, radiance);
  if (samples_glossy_) rays += glossy_.add(batch, radiance);
  return rays;
}

void DirectLight::add_open(const SurfaceBatch& batch, int surface, Vec3f* radiance) const {
  Vec3f& sum = radiance[batch.pixel[surface]];
  sum = sum + rays_->samples.contribution[surface];
}

// The rays leave the light, so that a group has one origin. They end on the viewer's side of the
// surface; their direction is rounded once per component, gamma(2) of its length.
std::uint64_t DirectLight::add_point(const SurfaceBatch& batch, const Light& light,
                                     Vec3f* radiance) {
  ShadowRays& rays = *rays_;
  rays.groups.clear();
  rays.samples.of_light(batch, light);
  for (int i = 0; i < batch.count; ++i) {
    if (!rays.samples.is_active[i]) continue;
    const Surface& s = batch.surface[i];
    const float distance = length(rays.samples.direction[i]);
    rays.add(i, s.point + s.normal * (s.offset + gamma(2) * distance) - light.position);
  }
  FanPacket packet;
  for (int a = 0; a < 3; ++a) packet.origin[a] = light.position[a];
  // What is closer to the light than it can be told from it is its housing.
  packet.t_min = 4 * kUnitRoundoff;
  std::fill_n(packet.t_max, kPacketRays, kEnd);
  const int groups = rays.groups.form(tracer_->kernels());
  for (int g = 0; g < groups; ++g) {
    rays.groups.fill(g, packet);
    std::uint64_t blocked = tracer_->occluded(packet);
    for (const int ray : rays.groups.group(g)) {
      if ((blocked & 1u) == 0) add_open(batch, rays.surface[ray], radiance);
      blocked >>= 1;
    }
  }
  return static_cast<std::uint64_t>(rays.groups.count());
}

// Traces the active rays of the groups that have been formed.
std::uint64_t DirectLight::trace_groups(const SurfaceBatch& batch, Vec3f* radiance) {
  ShadowRays& rays = *rays_;
  std::uint64_t count = 0;
  RayPacket packet;
  std::fill_n(packet.t_min, kPacketRays, 0.0f);
  std::fill_n(packet.t_max, kPacketRays, rays.t_max);
  const int groups = rays.groups.group_count();
  for (int g = 0; g < groups; ++g) {
    int surfaces[kPacketRays], n = 0;
    for (const int ray : rays.groups.group(g)) {
      const int s = rays.surface[ray];
      if (!rays.samples.is_active[s]) continue;
      for (int a = 0; a < 3; ++a) {
        packet.origin[a][n] = rays.samples.start[s][a];
        packet.direction[a][n] = rays.samples.direction[s][a];
      }
      surfaces[n++] = s;
    }
    if (n == 0) continue;
    packet.active = bits_below(n);
    const std::uint64_t blocked = tracer_->occluded(packet);
    for (int i = 0; i < n; ++i) {
      if ((blocked >> i & 1u) == 0) add_open(batch, surfaces[i], radiance);
    }
    count += static_cast<std::uint64_t>(n);
  }
  return count;
}

std::uint64_t DirectLight::add_directional(const SurfaceBatch& batch, const Light& light,
                                           Vec3f* radiance) {
  ShadowRays& rays = *rays_;
  rays.groups.clear();
  rays.t_max = std::numeric_limits<float>::infinity();
  const Vec3f to_light = -light.direction;
  // Seen from a point far behind the batch, parallel rays stand side by side.
  float extent = 0;
  for (int i = 0; i < batch.count; ++i) {
    const Vec3f from_first = batch.surface[i].point - batch.surface[0].point;
    extent = std::max(extent, length(from_first));
  }
  rays.samples.of_light(batch, light);
  for (int i = 0; i < batch.count; ++i) {
    if (!rays.samples.is_active[i]) continue;
    const Vec3f from_first = batch.surface[i].point - batch.surface[0].point;
    rays.add(i, from_first - to_light * (dot(from_first, to_light) + 4 * extent));
  }
  rays.groups.form(tracer_->kernels());
  return trace_groups(batch, radiance);
}

std::uint64_t DirectLight::add_emitters(const SurfaceBatch& batch, Vec3f* radiance) {
  ShadowRays& rays = *rays_;
  const LightSet& lights = scene_->lights;
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  const std::uint32_t rounds =
      picks_emitters_ ? 1u : static_cast<std::uint32_t>(lights.emitters.size());
  rays.t_max = kEnd;
  rays.samples.hold(batch);
  std::uint64_t count = 0;
  for (std::uint32_t round = 0; round < rounds; ++round) {
    // Groups that look alike from the middle of the emitter, or of the first of many.
    const Emitter& e = lights.emitters[round];
    const Vec3f middle = e.a + (e.edge_b + e.edge_c) * (1 / 3.0f);
    rays.groups.clear();
    for (int i = 0; i < batch.count; ++i) rays.add(i, batch.surface[i].point - middle);
    rays.groups.form(tracer_->kernels());
    for (std::uint32_t j = 0; j < samples && !is_over(); ++j) {
      rays.samples.of_emitter(batch, round, batch.sample_index * samples + j);
      count += trace_groups(batch, radiance);
    }
  }
  return count;
}

std::uint64_t DirectLight::add_environment(const SurfaceBatch& batch, Vec3f* radiance) {
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  ShadowRays& rays = *rays_;
  rays.t_max = std::numeric_limits<float>::infinity();
  std::uint64_t count = 0;
  for (std::uint32_t j = 0; j < samples && !is_over(); ++j) {
    rays.samples.of_sky(batch, batch.sample_index * samples + j);
    rays.groups.clear();
    for (int i = 0; i < batch.count; ++i) {
      if (rays.samples.is_active[i]) rays.add(i, rays.samples.direction[i]);
    }
    rays.groups.form(tracer_->kernels());
    count += trace_groups(batch, radiance);
  }
  return count;
}

}  // namespace tessera::core
