// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/path/path_tracer.h"

#include <algorithm>

#include "slave/core/ray/ray_bits.h"
#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {

RayCounts PathTracer::add(SurfaceBatch& batch, Vec3f* radiance) {
  RayCounts counts;
  counts.shadow += direct_.add(batch, radiance);
  // Paths have one ray more than bounces where rays find the light that light samples leave to
  // them; only the emission of the surfaces that it meets counts.
  const bool has_last = context_.scene.lights.has_environment ||
                        !context_.scene.lights.emitters.empty() ||
                        context_.scene.lights.has_partial_emission;
  const int rays = has_last ? bounces_ + 1 : bounces_;
  for (int depth = 1; depth <= rays && batch.count > 0 && !context_.is_over(); ++depth) {
    scatter(batch, static_cast<std::uint32_t>(depth));
    counts.secondary += follow(batch, radiance);
    if (context_.scene.features.has_specular) counts.secondary += chain_.follow(batch, radiance);
    if (depth <= bounces_) counts.shadow += direct_.add(batch, radiance);
  }
  return counts;
}

void PathTracer::scatter(const SurfaceBatch& batch, std::uint32_t depth) {
  rays_.clear();
  for (int i = 0; i < batch.count; ++i) {
    const std::uint32_t key = hash_combine(batch.key[i], dimension(Dimension::kNextSurface, depth));
    rays_.ask(i, key);
  }
  rays_.scatter(batch, dimension(Dimension::kScatter), batch.sample_index);
}

// Adds the sky's light along the rays that have met nothing. open: their bits, from ray `first` on.
void PathTracer::add_sky(int first, std::uint64_t open, Vec3f* radiance) {
  rays_.look_at_sky(open);
  for_each_ray(open, [&](int i) {
    Vec3f& sum = radiance[rays_.pixel(first + i)];
    sum = sum + rays_.sky_met(i);
  });
}

// Replaces the batch by what the rays meet. Returns: rays traced.
std::uint64_t PathTracer::follow(SurfaceBatch& batch, Vec3f* radiance) {
  batch.count = 0;
  rays_.trace_all();
  Surface* to[kPacketRays];
  for (int first = 0; first < rays_.count() && !context_.is_over(); first += kPacketRays) {
    const int n = std::min(kPacketRays, rays_.count() - first);
    const std::uint64_t met = rays_.take(first, n);
    if (context_.scene.lights.has_environment) add_sky(first, bits_below(n) & ~met, radiance);
    for_each_ray(met, [&](int i) {
      to[i] = &batch.surface[batch.count];
      batch.key[batch.count] = rays_.key(first + i);
      batch.pixel[batch.count++] = rays_.pixel(first + i);
    });
    rays_.meet(met, to, &batch);
    for_each_ray(met, [&](int i) {
      if (is_black(to[i]->emission)) return;
      Vec3f& sum = radiance[rays_.pixel(first + i)];
      sum = sum + rays_.emission_met(i, *to[i], true);
    });
  }
  return static_cast<std::uint64_t>(rays_.count());
}

}  // namespace tessera::core
