// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/specular_chain.h"

#include <algorithm>

#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

static_assert(kSpecularDepthMax < kSurfaceDimensions[3].count &&
              kSurfaceDimensions[3].first == Dimension::kSpecular);

}  // namespace

void SpecularChain::begin(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                          const std::atomic<bool>* is_cancelled, bool is_seen) {
  is_seen_ = is_seen;
  scene_ = &scene;
  if (scene.features.has_specular) rays_->scattered.begin(scene, tracer);
  is_cancelled_ = is_cancelled;
}

std::uint64_t SpecularChain::follow(SurfaceBatch& batch, Vec3f* radiance) {
  Rays& rays = *rays_;
  std::fill_n(rays.is_gone, batch.count, false);
  std::uint64_t traced = 0;
  for (std::uint32_t depth = 0; depth < kSpecularDepthMax; ++depth) {
    const int count = scatter(batch, depth);
    for (int first = 0; first < count;) {
      if (is_cancelled_ != nullptr && is_cancelled_->load(std::memory_order_relaxed)) return traced;
      const std::uint64_t group = rays.group[rays.order[first]];
      int n = 1;
      while (n < kPacketRays && first + n < count && rays.group[rays.order[first + n]] == group)
        ++n;
      trace_packet(batch, rays.order + first, n, radiance);
      first += n;
    }
    traced += static_cast<std::uint64_t>(count);
    if (count == 0) break;
  }
  int kept = 0;
  for (int i = 0; i < batch.count; ++i) {
    if (rays.is_gone[i] || is_specular(batch.surface[i])) continue;
    if (kept != i) {
      batch.surface[kept] = batch.surface[i];
      batch.pixel[kept] = batch.pixel[i];
      batch.key[kept] = batch.key[i];
    }
    ++kept;
  }
  batch.count = kept;
  return traced;
}

// One ray of each surface that is specular. Returns: how many.
int SpecularChain::scatter(const SurfaceBatch& batch, std::uint32_t depth) {
  Rays& rays = *rays_;
  ScatteredRays& scattered = rays.scattered;
  scattered.clear();
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    if (rays.is_gone[i] || !is_specular(s)) continue;
    scattered.ask(i, batch.key[i]);
    rays.is_gone[i] = true;  // until its ray has met something
  }
  scattered.scatter(batch, dimension(Dimension::kSpecular, depth), batch.sample_index);
  for (int ray = 0; ray < scattered.count; ++ray) {
    const Surface& s = batch.surface[scattered.origin[ray]];
    const bool is_through = dot(scattered.direction[ray], s.normal) < 0;
    const auto material = static_cast<std::uint64_t>(s.material - scene_->materials.data());
    rays.group[ray] = std::uint64_t{s.instance} << 32 | material << 1 | (is_through ? 1u : 0u);
    rays.order[ray] = ray;
  }
  std::sort(rays.order, rays.order + scattered.count, [&rays](int a, int b) {
    return rays.group[a] != rays.group[b] ? rays.group[a] < rays.group[b] : a < b;
  });
  return scattered.count;
}

void SpecularChain::trace_packet(SurfaceBatch& batch, const int* numbers, int n, Vec3f* radiance) {
  Rays& rays = *rays_;
  ScatteredRays& scattered = rays.scattered;
  const std::uint64_t met = scattered.trace(numbers, n);
  Surface* to[kPacketRays];
  for (int i = 0; i < n; ++i) to[i] = &batch.surface[scattered.origin[numbers[i]]];
  scattered.meet(met, to, &batch, is_seen_);
  if (scene_->lights.has_environment) scattered.look_at_sky(bits_below(n) & ~met);
  for (int i = 0; i < n; ++i) {
    const int ray = numbers[i];
    Vec3f& sum = radiance[scattered.pixel[ray]];
    if ((met >> i & 1u) == 0) {
      if (scene_->lights.has_environment) sum = sum + scattered.sky_met(i);
      continue;
    }
    rays.is_gone[scattered.origin[ray]] = false;
    sum = sum + scattered.weight[ray] * to[i]->emission;
  }
}

}  // namespace tessera::core
