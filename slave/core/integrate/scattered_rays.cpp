// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/scattered_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "slave/core/bsdf/specular.h"
#include "slave/core/integrate/own_primitive.h"
#include "slave/core/ray/ray_bits.h"

namespace tessera::core {
namespace {

// How much a lobe widens the cone of a pixel: a diffuse one by 0.2 for each unit of length, so that
// textures are looked up in levels that are at hand, and narrower lobes by their alpha's share of
// that.
constexpr float kDiffuseSpread = 0.2f;

}  // namespace

ScatteredRays::ScatteredRays(const RenderContext& context, Memory& memory)
    : context_(context),
      memory_(memory),
      met_(context.scene, context.tracer, memory.met),
      sky_(context.scene.lights, context.kernels(), memory.sky) {}

void ScatteredRays::clear() {
  count_ = asked_count_ = 0;
  memory_.rays.clear();
}

void ScatteredRays::scatter(const SurfaceBatch& batch, std::uint32_t dimension,
                            std::uint32_t sample) {
  static_assert(BsdfPacket::kMax == kSamplePoints);
  for (int first = 0; first < asked_count_; first += kSamplePoints) {
    memory_.samples.count = std::min(kSamplePoints, asked_count_ - first);
    for (int i = 0; i < memory_.samples.count; ++i)
      memory_.samples.key[i] = memory_.asked[first + i].key;
    context_.kernels().sample_points(dimension, sample, memory_.samples);
    scatter_some(batch, memory_.asked + first, memory_.samples.count);
  }
}

void ScatteredRays::scatter_some(const SurfaceBatch& batch, const Asked* asked, int n) {
  BsdfPackets::Place place[BsdfPacket::kMax];
  memory_.bsdfs.clear();
  for (int i = 0; i < n; ++i) {
    const Surface& s = batch.surface[asked[i].surface];
    if (is_specular(s)) continue;
    place[i] = memory_.bsdfs.add(s, batch.lobes_of(s),
                                 {memory_.samples.square[0][i], memory_.samples.square[1][i]});
  }
  memory_.bsdfs.sample(context_.kernels());
  for (int i = 0; i < n; ++i) {
    const Surface& s = batch.surface[asked[i].surface];
    if (is_specular(s)) {
      const SpecularSample out = sample_specular(
          s, s.to_viewer, {memory_.samples.square[0][i], memory_.samples.square[1][i]});
      push(batch, asked[i],
           {out.direction, out.weight * s.weight, 0, kDiffuseSpread * out.alpha, out.is_through});
      continue;
    }
    const BsdfPacket& from = *place[i].packet;
    const int k = place[i].number;
    if (scattering_of(s.bsdf) == Scattering::kEven) {
      push(batch, asked[i], {from.direction(k), s.albedo * s.weight, from.pdf(k), kDiffuseSpread});
    } else {
      push(batch, asked[i],
           {from.direction(k), from.weight(k) * s.weight, from.pdf(k),
            kDiffuseSpread * s.roughness * s.roughness});
    }
  }
}

// Drops rays that an interpolated normal has put below the surface, where there is nothing to see,
// and rays along the surface, whose cosine is nothing but rounding and which have no pdf for MIS.
void ScatteredRays::push(const SurfaceBatch& batch, const Asked& asked, const Scattered& out) {
  if (is_black(out.weight)) return;
  const Surface& s = batch.surface[asked.surface];
  if (!is_specular(s) && !(out.pdf > 0)) return;
  const Vec3f outward = s.normal * (out.is_through ? -1.0f : 1.0f);
  if (!(dot(out.direction, outward) > 0)) return;
  const int ray = count_++;
  memory_.origin[ray] = asked.surface;
  memory_.pixel[ray] = batch.pixel[asked.surface];
  memory_.key[ray] = asked.key;
  memory_.rays.put(ray, s.point + outward * s.offset, out.direction);
  if (!out.is_through) exclude_own(memory_.rays, ray, own_of(s), s.normal, out.direction);
  memory_.weight[ray] = out.weight;
  memory_.pdf[ray] = out.pdf;
  memory_.cone[ray] = s.cone.widened(out.widening);
}

void ScatteredRays::put(const int* numbers, int n, RayList& list, int packet) const {
  for (int i = 0; i < n; ++i) {
    list.put(packet * kPacketRays + i, memory_.rays.origin(numbers[i]),
             memory_.rays.direction(numbers[i]));
    list.exclude(packet * kPacketRays + i, memory_.rays.excluded(numbers[i]));
  }
}

std::uint64_t ScatteredRays::take(int first, int n) {
  for (int i = 0; i < n; ++i) memory_.number[i] = first + i;
  return find(memory_.rays, first / kPacketRays);
}

std::uint64_t ScatteredRays::take(const RayList& list, int packet, const int* numbers) {
  std::copy_n(numbers, std::popcount(list.active(packet)), memory_.number);
  return find(list, packet);
}

std::uint64_t ScatteredRays::find(const RayList& list, int packet) {
  list.copy_packet(packet, memory_.packet);
  memory_.found.copy_packet(packet, memory_.hits);
  met_.find(memory_.packet, memory_.hits);
  return met_.points().met;
}

void ScatteredRays::meet(std::uint64_t met, Surface* const* to, SurfaceBatch* batch, bool is_seen) {
  const bool has_cones = context_.scene.features.needs_cones();
  const RayCone* const cones = has_cones ? memory_.cones : nullptr;
  for_each_ray(has_cones ? met : 0,
               [&](int i) { memory_.cones[i] = memory_.cone[memory_.number[i]]; });
  if (is_seen)
    met_.make_seen(memory_.packet, memory_.hits, met, cones, to, batch);
  else
    met_.make(memory_.packet, memory_.hits, met, cones, to, batch);
  if (context_.scene.features.has_transmission) {
    for_each_ray(met,
                 [&](int i) { to[i]->weight = to[i]->weight * memory_.weight[memory_.number[i]]; });
  } else {
    for_each_ray(met, [&](int i) { to[i]->weight = memory_.weight[memory_.number[i]]; });
  }
}

Vec3f ScatteredRays::emission_met(int i, const Surface& s, bool is_picked) const {
  const int ray = memory_.number[i];
  const Emitter* emitter = context_.scene.lights.emitter_of(memory_.hits.primitive[i]);
  // Light samples look up emission textures without mip levels, and so does this: a surface that is
  // no emitter because its texture is black there must not shine through a mip level.
  if (emitter == nullptr) {
    const bool is_patch = (met_.on_patches() >> i & 1u) != 0;
    const bool is_left_out = s.material->emission_texture.is_set() && !is_patch &&
                             s.material->alpha.mode == AlphaMode::kOpaque;
    return is_left_out ? Vec3f{} : weight(ray) * s.emission;
  }
  const float chance = is_picked ? emitter->share : 1, t = memory_.hits.t[i];
  const PacketPoints& at = met_.points();
  const float area = context_.scene.lights.area_at(*emitter, at.u[i], at.v[i]);
  const float light = chance / area * (t * t) / std::fabs(dot(s.normal, direction(ray)));
  // A ray meets a lamp with the chance of its opacity, so what it brings is not multiplied by that.
  return weight(ray) * context_.scene.lights.emission_at(*emitter, at.u[i], at.v[i]) *
         (pdf(ray) / (pdf(ray) + light) / emitter->opacity);
}

Vec3f ScatteredRays::sky_met(int i) const {
  const int ray = memory_.number[i];
  const Vec3f light = weight(ray) * sky_.radiance(i);
  if (!sky_.has_map() || !(pdf(ray) > 0)) return light;
  return light * (pdf(ray) / (pdf(ray) + sky_.pdf(i)));
}

}  // namespace tessera::core
