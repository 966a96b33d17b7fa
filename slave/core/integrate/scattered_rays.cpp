// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/scattered_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/core/bsdf/specular.h"
#include "slave/core/ray/ray_bits.h"

namespace tessera::core {
namespace {

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
  count = asked_count_ = 0;
  packet_.habit = {};
  std::fill_n(packet_.t_min, kPacketRays, 0.0f);
  std::fill_n(packet_.t_max, kPacketRays, std::numeric_limits<float>::infinity());
}

void ScatteredRays::scatter(const SurfaceBatch& batch, std::uint32_t dimension,
                            std::uint32_t sample) {
  static_assert(BsdfPacket::kMax == kSamplePoints);
  for (int first = 0; first < asked_count_; first += kSamplePoints) {
    samples_.count = std::min(kSamplePoints, asked_count_ - first);
    for (int i = 0; i < samples_.count; ++i) samples_.key[i] = asked_[first + i].key;
    tracer_->kernels().sample_points(dimension, sample, samples_);
    scatter_some(batch, asked_ + first, samples_.count);
  }
}

void ScatteredRays::scatter_some(const SurfaceBatch& batch, const Asked* asked, int n) {
  int number[BsdfPacket::kMax];  // in its packet
  diffuse_.clear();
  glossy_.clear();
  layered_.clear();
  for (int i = 0; i < n; ++i) {
    const Surface& s = batch.surface[asked[i].surface];
    const Vec2f square{samples_.square[0][i], samples_.square[1][i]};
    if (s.bsdf == BsdfKind::kDiffuse) number[i] = diffuse_.add_diffuse(s.shading_normal, square);
    if (s.bsdf == BsdfKind::kGlossy) {
      number[i] = s.lobes == kNoLobes ? glossy_.add_glossy(s, square)
                                      : layered_.add_layered(s, batch.lobes[s.lobes], square);
    }
  }
  diffuse_.sample_diffuse(tracer_->kernels());
  if (glossy_.count() > 0) glossy_.sample_glossy(tracer_->kernels());
  if (layered_.count() > 0) layered_.sample_layered(tracer_->kernels());
  for (int i = 0; i < n; ++i) {
    const Surface& s = batch.surface[asked[i].surface];
    if (s.bsdf == BsdfKind::kDiffuse) {
      const int k = number[i];
      push(batch, asked[i],
           {diffuse_.direction(k), s.albedo * s.weight, diffuse_.pdf(k), kDiffuseSpread});
    } else if (s.bsdf == BsdfKind::kGlossy) {
      const int k = number[i];
      const BsdfPacket& from = s.lobes == kNoLobes ? glossy_ : layered_;
      push(batch, asked[i],
           {from.direction(k), from.weight(k) * s.weight, from.pdf(k),
            kDiffuseSpread * s.roughness * s.roughness});
    } else {
      const SpecularSample out =
          sample_specular(s, s.to_viewer, {samples_.square[0][i], samples_.square[1][i]});
      push(batch, asked[i],
           {out.direction, out.weight * s.weight, 0, kDiffuseSpread * out.alpha, out.is_through});
    }
  }
}

// Below the surface, by an interpolated normal, there is nothing to see; and a direction along it, whose
// cosine is nothing but rounding, would have no pdf to be weighed by.
void ScatteredRays::push(const SurfaceBatch& batch, const Asked& asked, const Scattered& out) {
  if (is_black(out.weight)) return;
  const Surface& s = batch.surface[asked.surface];
  if (!is_specular(s) && !(out.pdf > 0)) return;
  const Vec3f outward = s.normal * (out.is_through ? -1.0f : 1.0f);
  if (!(dot(out.direction, outward) > 0)) return;
  const int ray = count++;
  origin[ray] = asked.surface;
  pixel[ray] = batch.pixel[asked.surface];
  key[ray] = asked.key;
  start[ray] = s.point + outward * s.offset;
  direction[ray] = out.direction;
  weight[ray] = out.weight;
  pdf[ray] = out.pdf;
  cone[ray] = s.cone.widened(out.widening);
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

void ScatteredRays::meet(std::uint64_t met, Surface* const* to, SurfaceBatch* batch, bool is_seen) {
  RayCone cones[kPacketRays];
  const bool has_cones = scene_->features.needs_cones();
  for_each_ray(has_cones ? met : 0, [&](int i) { cones[i] = cone[number_[i]]; });
  if (is_seen)
    met_.make_seen(met, has_cones ? cones : nullptr, to, batch);
  else
    met_.make(met, has_cones ? cones : nullptr, to, batch);
  if (scene_->features.has_transmission) {
    for_each_ray(met, [&](int i) { to[i]->weight = to[i]->weight * weight[number_[i]]; });
  } else {
    for_each_ray(met, [&](int i) { to[i]->weight = weight[number_[i]]; });
  }
}

Vec3f ScatteredRays::emission_met(int i, const Surface& s, bool is_picked) const {
  const int ray = number_[i];
  const Emitter* emitter = scene_->lights.emitter_of(met_.triangle(i));
  // Light samples look at pictures of lamps as they are, not at their mip levels: so does this.
  if (emitter == nullptr) {
    const bool is_left_out =
        s.material->emission_texture.is_set() && s.material->alpha.mode == AlphaMode::kOpaque;
    return is_left_out ? Vec3f{} : weight[ray] * s.emission;
  }
  const float chance = is_picked ? emitter->share : 1, t = hits_.t[i];
  const float light = chance / emitter->area * (t * t) / std::fabs(dot(s.normal, direction[ray]));
  const PacketPoints& at = met_.points();
  return weight[ray] * scene_->lights.emission_at(*emitter, at.u[i], at.v[i]) *
         (pdf[ray] / (pdf[ray] + light));
}

Vec3f ScatteredRays::sky_met(int i) const {
  const int ray = number_[i];
  const Vec3f light = weight[ray] * sky_.radiance(i);
  if (!sky_.has_map() || !(pdf[ray] > 0)) return light;
  return light * (pdf[ray] / (pdf[ray] + sky_.pdf(i)));
}

}  // namespace tessera::core
