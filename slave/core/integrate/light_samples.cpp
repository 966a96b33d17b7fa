// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/light_samples.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "slave/core/light/light_sampling.h"
#include "slave/core/sampling/dimension.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {
namespace {

static_assert(2 * kEmittersEachMax <= kSurfaceDimensions[0].count);

constexpr float kInvPi = 0.318309886f;

// The cosine at the surface, zero where either normal says that the light is behind it: an
// interpolated normal may not let light through the surface.
float cosine_at(const Surface& s, Vec3f to_light) {
  if (!(dot(s.normal, to_light) > 0)) return 0;
  const float c = dot(s.shading_normal, to_light);
  return c > 0 ? c : 0;
}

bool is_usable(Vec3f c) { return is_finite(c) && (c.x > 0 || c.y > 0 || c.z > 0); }

// One packet size fits all of them.
static_assert(kLitPoints == kSamplePoints && kLitPoints == kPacketRays &&
              kLitPoints == BsdfPacket::kMax && kBatchMax % kLitPoints == 0);

}  // namespace

LightSamples::LightSamples(const RenderContext& context, Memory& memory, const Options& options)
    : context_(context),
      memory_(memory),
      options_(options),
      sky_(context.scene.lights, context.kernels(), memory.sky) {}

// Sets what an unoccluded surface sends to its pixel of the light that arrives, times the MIS
// weight of light samples (balance heuristic).
inline void LightSamples::settle(const SurfaceBatch& batch, int surface, Vec3f times_pi,
                                 float pdf) {
  const Arriving& a = memory_.arriving[surface];
  const float mis_weight = pdf > 0 && a.pdf > 0 ? a.pdf / (a.pdf + pdf) : 1;
  Vec3f& contribution = memory_.contribution[surface];
  contribution = times_pi * batch.surface[surface].weight * mis_weight * a.light * a.strength;
  memory_.is_active[surface] = is_usable(contribution);
}

void LightSamples::respond_in(int slot, const SurfaceBatch& batch) {
  Waiting& waiting = *memory_.waiting[slot];
  waiting.packet.evaluate(context_.kernels(), slot);
  for (int k = 0; k < waiting.packet.count(); ++k)
    settle(batch, waiting.surface[k], waiting.packet.times_pi(k), waiting.packet.pdf(k));
  waiting.packet.clear();
}

// Computes `contribution` from `arriving`. Diffuse surfaces that stand alone send out no rays of
// their own, so that their MIS weight is 1.
void LightSamples::respond(const SurfaceBatch& batch) {
  std::uint32_t used = 0;  // bits of slots
  for (int i = 0; i < batch.count; ++i) {
    if (!memory_.is_active[i]) continue;
    const Surface& s = batch.surface[i];
    const Vec3f to_light = memory_.arriving[i].to_light;
    if (scattering_of(s.bsdf) == Scattering::kEven) {
      settle(batch, i, s.albedo, options_.is_alone ? 0 : dot(s.shading_normal, to_light) * kInvPi);
      continue;
    }
    const int slot = slot_of(s);
    Waiting& waiting = memory_.waiting_in(slot);
    used |= 1u << slot;
    waiting.surface[waiting.packet.add(s, batch.lobes_of(s), to_light)] = i;
    if (waiting.packet.count() == BsdfPacket::kMax) respond_in(slot, batch);
  }
  for (; used != 0; used &= used - 1) {
    const int slot = std::countr_zero(used);
    if (memory_.waiting[slot]->packet.count() > 0) respond_in(slot, batch);
  }
}

void LightSamples::of_light(const SurfaceBatch& batch, const Light& light) {
  clear(batch.count);
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    if (light.kind == LightKind::kDirectional) {
      const Vec3f to_light = -light.direction;
      put(i, to_light, light.intensity, kInvPi * cosine_at(s, to_light), 0);
      memory_.start[i] = s.point + s.normal * s.offset;
      memory_.direction[i] = to_light;
    } else {
      const Vec3f away = light.position - s.point;
      const float distance2 = dot(away, away);
      const Vec3f to_light = away * (1 / std::sqrt(distance2));
      float strength = cosine_at(s, to_light) / distance2;
      if (light.kind == LightKind::kSpot)
        strength *= spot_falloff(light, -dot(light.direction, to_light));
      put(i, to_light, light.intensity, kInvPi * strength, 0);
      memory_.start[i] = s.point;
      memory_.direction[i] = away;
    }
  }
  respond(batch);
}

void LightSamples::hold(const SurfaceBatch& batch) {
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    LitSurfaces& lit = memory_.lit[i / kLitPoints];
    const int lane = i % kLitPoints;
    put_vector(s.point, lit.point, lane);
    put_vector(s.normal, lit.normal, lane);
    put_vector(s.shading_normal, lit.shading_normal, lane);
    lit.offset[lane] = s.offset;
  }
}

void LightSamples::of_emitter(const SurfaceBatch& batch, std::uint32_t emitter,
                              std::uint32_t sample) {
  clear(batch.count);
  if (!options_.picks_emitters) {
    for (int i = 0; i < kLitPoints; ++i) put_emitter(context_.scene.lights.emitters[emitter], i);
  }
  for (int first = 0; first < batch.count; first += kLitPoints)
    sample_emitters(batch, first, emitter, sample);
  respond(batch);
}

// Samples emitters for the packet of surfaces from `first` on.
void LightSamples::sample_emitters(const SurfaceBatch& batch, int first, std::uint32_t round,
                                   std::uint32_t sample) {
  const LightSet& lights = context_.scene.lights;
  EmitterSamples& e = memory_.emitters;
  draw(batch, first, dimension(Dimension::kEmitter, 2 * round), sample);
  const int n = e.count = memory_.samples.count;
  e.samples = static_cast<float>(options_.samples);
  std::memcpy(e.square, memory_.samples.square, sizeof(e.square));
  for (int i = 0; i < n && options_.picks_emitters; ++i)
    put_emitter(lights.pick(e.square[0][i], e.square[0][i]), i);
  const bool may_be_patches = kKnowsPatches && lights.patches != nullptr;
  if (may_be_patches) put_patch_points();
  context_.kernels().emitter_samples(memory_.lit[first / kLitPoints], e);
  if (may_be_patches) put_patch_places();
  for (int i = 0; i < n; ++i) {
    if (!(e.strength[i] > 0)) continue;
    const int s = first + i;
    put(s, vector_at(e.to_light, i), lights.emission_at(*memory_.emitter[i], e.u[i], e.v[i]),
        e.strength[i], e.pdf[i]);
    memory_.start[s] = vector_at(e.start, i);
    memory_.direction[s] = vector_at(e.direction, i);
  }
}

// An emitter that is a patch is, for each sample, one that is all at the sample's point.
void LightSamples::put_patch_points() {
  EmitterSamples& e = memory_.emitters;
  for (int i = 0; i < e.count; ++i) {
    const Emitter& emitter = *memory_.emitter[i];
    if (!emitter.is_patch()) continue;
    const PatchEmitterPoint on =
        sample_on_patch(*context_.scene.lights.patches, emitter, {e.square[0][i], e.square[1][i]});
    put_vector(on.point, e.a, i);
    put_vector(on.normal, e.emitter_normal, i);
    e.area[i] = on.area;
    memory_.on_patch[0][i] = on.u;
    memory_.on_patch[1][i] = on.v;
  }
}

void LightSamples::put_patch_places() {
  EmitterSamples& e = memory_.emitters;
  for (int i = 0; i < e.count; ++i) {
    if (!memory_.emitter[i]->is_patch()) continue;
    e.u[i] = memory_.on_patch[0][i];
    e.v[i] = memory_.on_patch[1][i];
  }
}

void LightSamples::put_emitter(const Emitter& emitter, int i) {
  EmitterSamples& e = memory_.emitters;
  memory_.emitter[i] = &emitter;
  put_vector(emitter.a, e.a, i);
  put_vector(emitter.edge_b, e.edge_b, i);
  put_vector(emitter.edge_c, e.edge_c, i);
  put_vector(emitter.normal, e.emitter_normal, i);
  e.area[i] = emitter.area;
  e.chance[i] = options_.picks_emitters ? emitter.share : 1;
}

void LightSamples::of_sky(const SurfaceBatch& batch, std::uint32_t sample) {
  clear(batch.count);
  sky_.has_map() ? sample_map(batch, sample) : sample_even_sky(batch, sample);
  respond(batch);
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    memory_.start[i] = s.point + s.normal * s.offset;
    memory_.direction[i] = memory_.arriving[i].to_light;
  }
}

// Draws points of the sequence for the packet of surfaces from `first` on.
void LightSamples::draw(const SurfaceBatch& batch, int first, std::uint32_t dimension,
                        std::uint32_t sample) {
  SamplePoints& points = memory_.samples;
  points.count = std::min(kSamplePoints, batch.count - first);
  std::copy_n(batch.key + first, points.count, points.key);
  context_.kernels().sample_points(dimension, sample, points);
}

// An even sky is sampled for diffuse surfaces alone: directions of pdf cosine / pi leave the albedo
// as the weight of what they meet. A direction that an interpolated normal has put below the
// surface sees nothing.
void LightSamples::sample_even_sky(const SurfaceBatch& batch, std::uint32_t sample) {
  const float each = 1 / static_cast<float>(options_.samples);
  for (int first = 0; first < batch.count; first += BsdfPacket::kMax) {
    const int end = std::min(first + BsdfPacket::kMax, batch.count);
    BsdfPacket& packet = memory_.sky_directions;
    packet.clear();
    draw(batch, first, dimension(Dimension::kEnvironment), sample);
    for (int i = first; i < end; ++i) {
      const auto& square = memory_.samples.square;
      packet.add_diffuse(batch.surface[i].shading_normal,
                         {square[0][i - first], square[1][i - first]});
    }
    packet.sample_diffuse(context_.kernels());
    for (int i = first; i < end; ++i) {
      const Vec3f to_sky = packet.direction(i - first);
      const Surface& s = batch.surface[i];
      if (scattering_of(s.bsdf) == Scattering::kEven && dot(s.normal, to_sky) > 0)
        put(i, to_sky, context_.scene.lights.environment, each, 0);
    }
  }
}

// An environment map is sampled for surfaces of all kinds.
void LightSamples::sample_map(const SurfaceBatch& batch, std::uint32_t sample) {
  const float each = 1 / static_cast<float>(options_.samples);
  for (int first = 0; first < batch.count; first += kPacketRays) {
    draw(batch, first, dimension(Dimension::kEnvironment), sample);
    sky_.sample(memory_.samples);
    for (int i = 0; i < memory_.samples.count; ++i) {
      const SkyMap::Sample sky = sky_.drawn(i);
      const float strength = cosine_at(batch.surface[first + i], sky.direction) * sky.angle;
      put(first + i, sky.direction, sky.radiance * context_.scene.lights.environment,
          strength * kInvPi * each, 1 / sky.angle);
    }
  }
}

}  // namespace tessera::core
