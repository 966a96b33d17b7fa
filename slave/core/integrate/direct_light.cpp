// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/direct_light.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "common/math/rounding.h"
#include "slave/core/integrate/light_samples.h"
#include "slave/core/integrate/own_primitive.h"
#include "slave/core/ray/ray_bits.h"

namespace tessera::core {
namespace {

// End of shadow rays whose light is at 1. A reported t is off by up to 3 roundings (plane-inl.h),
// so that nothing that lies beyond 1 is hit.
constexpr float kEnd = 1 - 4 * kUnitRoundoff;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Kind = DirectLight::Kind;

bool picks_emitters(const LightSet& lights, Kind kind) {
  return kind == Kind::kPartOfPath || lights.is_shared_out();
}
// Whether glossy surfaces send out rays of their own, for the light that light samples leave to
// them.
bool samples_glossy(const PreparedScene::Impl& scene, Kind kind) {
  return kind == Kind::kWhole && scene.features.has_glossy &&
         (scene.lights.has_environment || !scene.lights.emitters.empty());
}

}  // namespace

DirectLight::DirectLight(const RenderContext& context, Memory& memory, Kind kind)
    : context_(context),
      memory_(memory),
      kind_(kind),
      light_samples_(kind == Kind::kWhole ? context.settings.light_samples : 1),
      picks_emitters_(picks_emitters(context.scene.lights, kind)),
      samples_(context, memory.samples, {light_samples_, kind == Kind::kWhole, picks_emitters_}) {
  if (!samples_glossy(context.scene, kind)) return;
  if (memory.glossy == nullptr) memory.glossy = std::make_unique<ScatteredRays::Memory>();
  glossy_.emplace(context, *memory.glossy);
}

std::uint64_t DirectLight::add(const SurfaceBatch& batch, Vec3f* radiance) {
  std::uint64_t rays = 0;
  for (const Light& light : context_.scene.lights.lights) {
    if (context_.is_over()) return rays;
    rays += light.kind == LightKind::kDirectional ? add_directional(batch, light, radiance)
                                                  : add_point(batch, light, radiance);
  }
  if (!context_.scene.lights.emitters.empty()) rays += add_emitters(batch, radiance);
  if (samples_environment()) rays += add_environment(batch, radiance);
  if (context_.scene.features.has_glossy && glossy_) rays += glossy_->add(batch, radiance);
  return rays;
}

void DirectLight::add_open(const SurfaceBatch& batch, int surface, Vec3f* radiance) const {
  Vec3f& sum = radiance[batch.pixel[surface]];
  sum = sum + samples_.contribution(surface);
}

// The rays leave the light, so that a group has one origin. They end on the viewer's side of the
// surface; their direction is rounded once per component, gamma(2) of its length.
std::uint64_t DirectLight::add_point(const SurfaceBatch& batch, const Light& light,
                                     Vec3f* radiance) {
  memory_.groups.clear();
  samples_.of_light(batch, light);
  for (int i = 0; i < batch.count; ++i) {
    if (!samples_.is_active(i)) continue;
    const Surface& s = batch.surface[i];
    const float distance = length(samples_.direction(i));
    const Vec3f from_light = s.point + s.normal * (s.offset + gamma(2) * distance) - light.position;
    exclude_own(memory_.groups, memory_.groups.count(), own_of(s), s.normal, -from_light);
    ask(i, from_light);
  }
  // What is so close to the light that rounding hides the distance is the light's housing.
  constexpr float kBegin = 4 * kUnitRoundoff;
  const int groups = memory_.groups.form(context_.kernels());
  context_.tracer.occluded(memory_.groups.fans_from(light.position, kBegin, kEnd), memory_.blocked);
  for (int g = 0; g < groups; ++g) {
    std::uint64_t blocked = memory_.blocked[g];
    for (const int ray : memory_.groups.group(g)) {
      if ((blocked & 1u) == 0) add_open(batch, memory_.surface[ray], radiance);
      blocked >>= 1;
    }
  }
  return static_cast<std::uint64_t>(memory_.groups.count());
}

// Makes the active rays of a group, of which there may be none, the next packet.
void DirectLight::put_group(const SurfaceBatch& batch, int group, float t_max) {
  int place = memory_.rays.packet_count() * kPacketRays;
  for (const int ray : memory_.groups.group(group)) {
    const int s = memory_.surface[ray];
    if (!samples_.is_active(s)) continue;
    memory_.rays.put(place, samples_.start(s), samples_.direction(s), t_max);
    const Surface& from = batch.surface[s];
    exclude_own(memory_.rays, place, own_of(from), from.normal, samples_.direction(s));
    memory_.lit[place++] = s;
  }
}

std::uint64_t DirectLight::trace_groups(const SurfaceBatch& batch, float t_max, Vec3f* radiance) {
  std::uint64_t count = 0;
  RayList& rays = memory_.rays;
  const int groups = memory_.groups.group_count();
  for (int g = 0; g < groups;) {
    rays.clear();
    while (g < groups && rays.packet_count() < RayList::kPacketsMax) put_group(batch, g++, t_max);
    context_.tracer.occluded(rays.many(), memory_.blocked);
    for (int p = 0; p < rays.packet_count(); ++p) {
      for_each_ray(rays.active(p) & ~memory_.blocked[p],
                   [&](int i) { add_open(batch, memory_.lit[p * kPacketRays + i], radiance); });
      count += static_cast<std::uint64_t>(std::popcount(rays.active(p)));
    }
  }
  return count;
}

std::uint64_t DirectLight::add_directional(const SurfaceBatch& batch, const Light& light,
                                           Vec3f* radiance) {
  memory_.groups.clear();
  const Vec3f to_light = -light.direction;
  // Seen from a point far behind the batch, parallel rays stand side by side.
  float extent = 0;
  for (int i = 0; i < batch.count; ++i) {
    const Vec3f from_first = batch.surface[i].point - batch.surface[0].point;
    extent = std::max(extent, length(from_first));
  }
  samples_.of_light(batch, light);
  for (int i = 0; i < batch.count; ++i) {
    if (!samples_.is_active(i)) continue;
    const Vec3f from_first = batch.surface[i].point - batch.surface[0].point;
    ask(i, from_first - to_light * (dot(from_first, to_light) + 4 * extent));
  }
  memory_.groups.form(context_.kernels());
  return trace_groups(batch, kInfinity, radiance);
}

std::uint64_t DirectLight::add_emitters(const SurfaceBatch& batch, Vec3f* radiance) {
  const LightSet& lights = context_.scene.lights;
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  const std::uint32_t rounds =
      picks_emitters_ ? 1u : static_cast<std::uint32_t>(lights.emitters.size());
  samples_.hold(batch);
  std::uint64_t count = 0;
  for (std::uint32_t round = 0; round < rounds; ++round) {
    // Groups are formed as seen from the middle of the emitter, or of the first of many.
    const Emitter& e = lights.emitters[round];
    const Vec3f middle = e.a + (e.edge_b + e.edge_c) * (1 / 3.0f);
    memory_.groups.clear();
    for (int i = 0; i < batch.count; ++i) ask(i, batch.surface[i].point - middle);
    memory_.groups.form(context_.kernels());
    for (std::uint32_t j = 0; j < samples && !context_.is_over(); ++j) {
      samples_.of_emitter(batch, round, batch.sample_index * samples + j);
      count += trace_groups(batch, kEnd, radiance);
    }
  }
  return count;
}

std::uint64_t DirectLight::add_environment(const SurfaceBatch& batch, Vec3f* radiance) {
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  std::uint64_t count = 0;
  for (std::uint32_t j = 0; j < samples && !context_.is_over(); ++j) {
    samples_.of_sky(batch, batch.sample_index * samples + j);
    memory_.groups.clear();
    for (int i = 0; i < batch.count; ++i) {
      if (samples_.is_active(i)) ask(i, samples_.direction(i));
    }
    memory_.groups.form(context_.kernels());
    count += trace_groups(batch, kInfinity, radiance);
  }
  return count;
}

}  // namespace tessera::core
