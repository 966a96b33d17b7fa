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

std::uint64_t SpecularChain::follow(SurfaceBatch& batch, Vec3f* radiance) {
  std::fill_n(memory_.is_gone, batch.count, false);
  std::uint64_t traced = 0;
  for (std::uint32_t depth = 0; depth < kSpecularDepthMax; ++depth) {
    const int count = scatter(batch, depth);
    for (int first = 0; first < count;) {
      if (context_.is_over()) return traced;
      const std::uint64_t group = memory_.group[memory_.order[first]];
      int n = 1;
      while (n < kPacketRays && first + n < count &&
             memory_.group[memory_.order[first + n]] == group)
        ++n;
      trace_packet(batch, memory_.order + first, n, radiance);
      first += n;
    }
    traced += static_cast<std::uint64_t>(count);
    if (count == 0) break;
  }
  int kept = 0;
  for (int i = 0; i < batch.count; ++i) {
    if (memory_.is_gone[i] || is_specular(batch.surface[i])) continue;
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

// Makes one ray for each specular surface. Returns: the number of rays.
int SpecularChain::scatter(const SurfaceBatch& batch, std::uint32_t depth) {
  rays_.clear();
  for (int i = 0; i < batch.count; ++i) {
    const Surface& s = batch.surface[i];
    if (memory_.is_gone[i] || !is_specular(s)) continue;
    rays_.ask(i, batch.key[i]);
    memory_.is_gone[i] = true;  // until its ray has met something
  }
  rays_.scatter(batch, dimension(Dimension::kSpecular, depth), batch.sample_index);
  for (int ray = 0; ray < rays_.count(); ++ray) {
    const Surface& s = batch.surface[rays_.origin(ray)];
    const bool is_through = dot(rays_.direction(ray), s.normal) < 0;
    const auto material = static_cast<std::uint64_t>(s.material - context_.scene.materials.data());
    memory_.group[ray] = std::uint64_t{s.instance} << 32 | material << 1 | (is_through ? 1u : 0u);
    memory_.order[ray] = ray;
  }
  std::sort(memory_.order, memory_.order + rays_.count(), [this](int a, int b) {
    return memory_.group[a] != memory_.group[b] ? memory_.group[a] < memory_.group[b] : a < b;
  });
  return rays_.count();
}

void SpecularChain::trace_packet(SurfaceBatch& batch, const int* numbers, int n, Vec3f* radiance) {
  const std::uint64_t met = rays_.trace(numbers, n);
  Surface* to[kPacketRays];
  for (int i = 0; i < n; ++i) to[i] = &batch.surface[rays_.origin(numbers[i])];
  rays_.meet(met, to, &batch, is_seen_);
  if (context_.scene.lights.has_environment) rays_.look_at_sky(bits_below(n) & ~met);
  for (int i = 0; i < n; ++i) {
    const int ray = numbers[i];
    Vec3f& sum = radiance[rays_.pixel(ray)];
    if ((met >> i & 1u) == 0) {
      if (context_.scene.lights.has_environment) sum = sum + rays_.sky_met(i);
      continue;
    }
    memory_.is_gone[rays_.origin(ray)] = false;
    sum = sum + rays_.weight(ray) * to[i]->emission;
  }
}

}  // namespace tessera::core
