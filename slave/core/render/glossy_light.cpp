#include "slave/core/render/glossy_light.h"

#include <algorithm>

#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

// Apart from those of light samples (direct_light.cpp).
constexpr std::uint32_t kDimensionGlossy = 0x80000003u;

}  // namespace

void GlossyLight::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer, int samples,
                        const std::atomic<bool>* is_cancelled) {
  scene_ = &scene;
  tracer_ = &tracer;
  samples_ = samples;
  is_cancelled_ = is_cancelled;
  if (!rays_) rays_ = std::make_unique<ScatteredRays>();
}

std::uint64_t GlossyLight::add(const SurfaceBatch& batch, Vec3f* radiance) {
  std::uint64_t traced = 0;
  const auto samples = static_cast<std::uint32_t>(samples_);
  for (std::uint32_t j = 0; j < samples; ++j) {
    if (is_cancelled_ != nullptr && is_cancelled_->load(std::memory_order_relaxed)) break;
    rays_->clear();
    for (int i = 0; i < batch.count; ++i) {
      if (batch.surface[i].bsdf != BsdfKind::kGlossy) continue;
      const std::uint32_t key = hash_combine(batch.key[i], kDimensionGlossy);
      rays_->add(batch, i, shuffled_2d(key, batch.sample_index * samples + j), key);
    }
    trace(radiance);
    traced += static_cast<std::uint64_t>(rays_->count);
  }
  return traced;
}

void GlossyLight::trace(Vec3f* radiance) {
  const LightSet& lights = scene_->lights;
  const float each = 1 / static_cast<float>(samples_);
  PacketHits hits;
  Surface met;
  int numbers[kPacketRays];
  for (int first = 0; first < rays_->count; first += kPacketRays) {
    const int n = std::min(kPacketRays, rays_->count - first);
    for (int i = 0; i < n; ++i) numbers[i] = first + i;
    rays_->trace(*tracer_, numbers, n, hits);
    for (int i = 0; i < n; ++i) {
      const int ray = first + i;
      Vec3f light;
      if (!rays_->meet(*scene_, ray, hits.primitive[i], hits.t[i], met)) {
        light = rays_->sky_met(lights, ray);
      } else if (!is_black(met.emission)) {
        light = rays_->emission_met(*scene_, ray, hits.primitive[i], hits.t[i], met,
                                    lights.is_shared_out());
      }
      Vec3f& sum = radiance[rays_->pixel[ray]];
      sum = sum + light * each;
    }
  }
}

}  // namespace tessera::core
