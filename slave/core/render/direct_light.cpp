#include "slave/core/render/direct_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "slave/core/light/light_sampling.h"
#include "slave/core/render/bsdf_packet.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;
// Apart from those of the emitters, which have even numbers, one for each.
constexpr std::uint32_t kEnvironmentDimension = 0x80000001u;
// A reported t is off by 3 roundings (plane-inl.h): what lies beyond 1 for certain is not hit.
constexpr float kEnd = 1 - 4 * kUnitRoundoff;

// The cosine at the surface, zero where either normal says that the light is behind it: an
// interpolated normal may not let light through the surface.
float cosine_at(const Surface& s, Vec3f to_light) {
  if (!(dot(s.normal, to_light) > 0)) return 0;
  const float c = dot(s.shading_normal, to_light);
  return c > 0 ? c : 0;
}

void put(Vec3f v, float (&to)[3][kLitPoints], int i) {
  to[0][i] = v.x;
  to[1][i] = v.y;
  to[2][i] = v.z;
}
Vec3f at(const float (&v)[3][kLitPoints], int i) { return {v[0][i], v[1][i], v[2][i]}; }

bool is_usable(Vec3f c) { return is_finite(c) && (c.x > 0 || c.y > 0 || c.z > 0); }

}  // namespace

// Of the surfaces of a batch towards one light sample each.
struct DirectLight::ShadowRays {
  // A light sample.
  struct Arriving {
    Vec3f to_light, light;  // unit; radiance, or intensity
    float strength;         // of which the surface gets so much, if nothing is in the way
    float density;          // by solid angle; 0 where no ray of the BSDF's own can find it
  };
  Arriving arriving[kBatchMax];  // by surface
  BsdfPacket glossy;
  int glossy_surface[BsdfPacket::kMax];

  SamplePoints samples{};
  LitSurfaces lit[kBatchMax / kLitPoints];
  EmitterSamples emitters{};
  const Emitter* emitter[kLitPoints];  // of them

  RayGroups groups;
  int surface[kBatchMax];      // of a ray of `groups`
  Vec3f start[kBatchMax];      // by surface, as all that follows
  Vec3f direction[kBatchMax];  // from start
  Vec3f contribution[kBatchMax];
  bool is_active[kBatchMax];
  float t_max = 1;

  void begin(int count) { std::fill_n(is_active, count, false); }
  void put(int s, const Arriving& from) {
    arriving[s] = from;
    is_active[s] = from.strength > 0;
  }
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
  is_alone_ = kind == Kind::kWhole;
  picks_emitters_ = kind == Kind::kPartOfPath || scene.lights.is_shared_out();
  samples_environment_ =
      scene.lights.has_environment && (kind == Kind::kWhole || scene.lights.sky_map);
  samples_glossy_ = kind == Kind::kWhole && scene.features.has_glossy &&
                    (scene.lights.has_environment || !scene.lights.emitters.empty());
  is_cancelled_ = is_cancelled;
  sky_.begin(scene.lights, tracer.kernels());
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
  sum = sum + rays_->contribution[surface];
}

// What surfaces send to their pixels of what arrives, if nothing is in the way: from `arriving` to
// `contribution`, times the share of light samples among two ways to find it (the balance heuristic).
// Diffuse surfaces that stand alone send out no rays of their own.
void DirectLight::respond(const SurfaceBatch& batch) {
  ShadowRays& rays = *rays_;
  const auto settle = [&](int i, Vec3f times_pi, float density) {
    const ShadowRays::Arriving& a = rays.arriving[i];
    const float share = density > 0 && a.density > 0 ? a.density / (a.density + density) : 1;
    rays.contribution[i] = times_pi * batch.surface[i].weight * share * a.light * a.strength;
    rays.is_active[i] = is_usable(rays.contribution[i]);
  };
  const auto settle_glossy = [&] {
    rays.glossy.evaluate_glossy(tracer_->kernels());
    for (int k = 0; k < rays.glossy.count(); ++k)
      settle(rays.glossy_surface[k], rays.glossy.times_pi(k), rays.glossy.density(k));
    rays.glossy.clear();
  };
  rays.glossy.clear();
  for (int i = 0; i < batch.count; ++i) {
    if (!rays.is_active[i]) continue;
    const Surface& s = batch.surface[i];
    const Vec3f to_light = rays.arriving[i].to_light;
    if (s.bsdf == BsdfKind::kDiffuse) {
      settle(i, s.albedo, is_alone_ ? 0 : dot(s.shading_normal, to_light) * kInvPi);
      continue;
    }
    rays.glossy_surface[rays.glossy.add_glossy(s, to_light)] = i;
    if (rays.glossy.count() == BsdfPacket::kMax) settle_glossy();
  }
  if (rays.glossy.count() > 0) settle_glossy();
}

// The rays leave the light, so that a group has one origin. They end on the viewer's side of the
// surface; their direction is rounded once per component, gamma(2) of its length.
std::uint64_t DirectLight::add_point(const SurfaceBatch& batch, const Light& light,
                                     Vec3f* radiance) {
  ShadowRays& rays = *rays_;
  rays.groups.clear();
  rays.begin(batch.count);
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    const Vec3f away = light.position - s.point;
    const float distance2 = dot(away, away), distance = std::sqrt(distance2);
    const Vec3f to_light = away * (1 / distance);
    float strength = cosine_at(s, to_light) / distance2;
    if (light.kind == LightKind::kSpot)
      strength *= spot_falloff(light, -dot(light.direction, to_light));
    rays.put(i, {to_light, light.intensity, kInvPi * strength, 0});
  }
  respond(batch);
  for (int i = 0; i < batch.count; ++i) {
    if (!rays.is_active[i]) continue;
    const Surface& s = batch.surface[i];
    const float distance = length(light.position - s.point);
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
      if (!rays.is_active[s]) continue;
      for (int a = 0; a < 3; ++a) {
        packet.origin[a][n] = rays.start[s][a];
        packet.direction[a][n] = rays.direction[s][a];
      }
      surfaces[n++] = s;
    }
    if (n == 0) continue;
    packet.active = ~std::uint64_t{0} >> (kPacketRays - n);
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
  rays.begin(batch.count);
  for (int i = 0; i < batch.count; ++i)
    rays.put(i, {to_light, light.intensity, kInvPi * cosine_at(batch.surface[i], to_light), 0});
  respond(batch);
  for (int i = 0; i < batch.count; ++i) {
    if (!rays.is_active[i]) continue;
    const Surface& s = batch.surface[i];
    rays.start[i] = s.point + s.normal * s.offset;
    rays.direction[i] = to_light;
    const Vec3f from_first = s.point - batch.surface[0].point;
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
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    LitSurfaces& lit = rays.lit[i / kLitPoints];
    const int lane = i % kLitPoints;
    put(s.point, lit.point, lane);
    put(s.normal, lit.normal, lane);
    put(s.shading_normal, lit.shading_normal, lane);
    lit.offset[lane] = s.offset;
  }
  std::uint64_t count = 0;
  for (std::uint32_t round = 0; round < rounds; ++round) {
    // Groups that look alike from the middle of the emitter, or of the first of many.
    const Emitter& e = lights.emitters[round];
    const Vec3f middle = e.a + (e.edge_b + e.edge_c) * (1 / 3.0f);
    rays.groups.clear();
    for (int i = 0; i < batch.count; ++i) rays.add(i, batch.surface[i].point - middle);
    rays.groups.form(tracer_->kernels());
    for (std::uint32_t j = 0; j < samples && !is_over(); ++j) {
      count += add_sample(batch, round, batch.sample_index * samples + j, radiance);
    }
  }
  return count;
}

std::uint64_t DirectLight::add_environment(const SurfaceBatch& batch, Vec3f* radiance) {
  const auto samples = static_cast<std::uint32_t>(light_samples_);
  const bool has_map = scene_->lights.sky_map != nullptr;
  ShadowRays& rays = *rays_;
  rays.t_max = std::numeric_limits<float>::infinity();
  std::uint64_t count = 0;
  for (std::uint32_t j = 0; j < samples && !is_over(); ++j) {
    const std::uint32_t sample = batch.sample_index * samples + j;
    rays.groups.clear();
    rays.begin(batch.count);
    has_map ? sample_map(batch, sample) : sample_even_sky(batch, sample);
    respond(batch);
    for (int i = 0; i < batch.count; ++i) {
      if (!rays.is_active[i]) continue;
      const Surface& s = batch.surface[i];
      rays.start[i] = s.point + s.normal * s.offset;
      rays.direction[i] = rays.arriving[i].to_light;
      rays.add(i, rays.direction[i]);
    }
    rays.groups.form(tracer_->kernels());
    count += trace_groups(batch, radiance);
  }
  return count;
}

// Points of the sequence for the surfaces from `first` on, a packet of them.
void DirectLight::draw(const SurfaceBatch& batch, int first, std::uint32_t dimension,
                       std::uint32_t sample) {
  SamplePoints& points = rays_->samples;
  points.count = std::min(kSamplePoints, batch.count - first);
  std::copy_n(batch.key + first, points.count, points.key);
  tracer_->kernels().sample_points(dimension, sample, points);
}

// An even sky is for diffuse surfaces: directions of density cosine / pi leave the albedo as the
// weight of what they meet. One that an interpolated normal has put below the surface sees nothing.
void DirectLight::sample_even_sky(const SurfaceBatch& batch, std::uint32_t sample) {
  const float each = 1 / static_cast<float>(light_samples_);
  for (int first = 0; first < batch.count; first += BsdfPacket::kMax) {
    const int end = std::min(first + BsdfPacket::kMax, batch.count);
    BsdfPacket& packet = rays_->glossy;  // free until the response
    packet.clear();
    draw(batch, first, kEnvironmentDimension, sample);
    for (int i = first; i < end; ++i) {
      const auto& square = rays_->samples.square;
      packet.add_diffuse(batch.surface[i].shading_normal,
                         {square[0][i - first], square[1][i - first]});
    }
    packet.sample_diffuse(tracer_->kernels());
    for (int i = first; i < end; ++i) {
      const Vec3f to_sky = packet.direction(i - first);
      const Surface& s = batch.surface[i];
      if (s.bsdf == BsdfKind::kDiffuse && dot(s.normal, to_sky) > 0)
        rays_->put(i, {to_sky, scene_->lights.environment, each, 0});
    }
  }
}

// A map is sampled for all.
void DirectLight::sample_map(const SurfaceBatch& batch, std::uint32_t sample) {
  const float each = 1 / static_cast<float>(light_samples_);
  for (int first = 0; first < batch.count; first += kPacketRays) {
    draw(batch, first, kEnvironmentDimension, sample);
    sky_.sample(rays_->samples);
    for (int i = 0; i < rays_->samples.count; ++i) {
      const SkyMap::Sample sky = sky_.drawn(i);
      const float strength = cosine_at(batch.surface[first + i], sky.direction) * sky.angle;
      rays_->put(first + i, {sky.direction, sky.radiance * scene_->lights.environment,
                             strength * kInvPi * each, 1 / sky.angle});
    }
  }
}

// One sample of an emitter, or of one that is picked, for each surface.
std::uint64_t DirectLight::add_sample(const SurfaceBatch& batch, std::uint32_t round,
                                      std::uint32_t sample, Vec3f* radiance) {
  rays_->begin(batch.count);
  if (!picks_emitters_) {
    for (int i = 0; i < kLitPoints; ++i) put_emitter(scene_->lights.emitters[round], i);
  }
  for (int first = 0; first < batch.count; first += kLitPoints)
    sample_emitters(batch, first, round, sample);
  respond(batch);
  return trace_groups(batch, radiance);
}

// Of the surfaces from `first` on.
void DirectLight::sample_emitters(const SurfaceBatch& batch, int first, std::uint32_t round,
                                  std::uint32_t sample) {
  ShadowRays& rays = *rays_;
  const LightSet& lights = scene_->lights;
  EmitterSamples& e = rays.emitters;
  draw(batch, first, 2 * round, sample);
  const int n = e.count = rays.samples.count;
  e.samples = static_cast<float>(light_samples_);
  std::memcpy(e.square, rays.samples.square, sizeof(e.square));
  for (int i = 0; i < n && picks_emitters_; ++i)
    put_emitter(lights.pick(e.square[0][i], e.square[0][i]), i);
  tracer_->kernels().emitter_samples(rays.lit[first / kLitPoints], e);
  for (int i = 0; i < n; ++i) {
    if (!(e.strength[i] > 0)) continue;
    const int s = first + i;
    rays.put(s, {at(e.to_light, i), lights.emission_at(*rays.emitter[i], e.u[i], e.v[i]),
                 e.strength[i], e.density[i]});
    rays.start[s] = at(e.start, i);
    rays.direction[s] = at(e.direction, i);
  }
}

void DirectLight::put_emitter(const Emitter& emitter, int i) {
  EmitterSamples& e = rays_->emitters;
  rays_->emitter[i] = &emitter;
  put(emitter.a, e.a, i);
  put(emitter.edge_b, e.edge_b, i);
  put(emitter.edge_c, e.edge_c, i);
  put(emitter.normal, e.emitter_normal, i);
  e.area[i] = emitter.area;
  e.chance[i] = picks_emitters_ ? emitter.share : 1;
}

}  // namespace tessera::core
