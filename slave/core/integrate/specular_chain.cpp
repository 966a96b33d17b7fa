// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/specular_chain.h"

#include <algorithm>

#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

static_assert(kSpecularDepthMax < kSurfaceDimensions[3].count &&
              kSurfaceDimensions[3].first == Dimension::kSpecular);

// Fewer rays are no bundle, however much they look alike (ray/bundle_rays-inl.h), and share packets
// with others.
constexpr int kCompanyLeast = 12;

}  // namespace

std::uint64_t SpecularChain::follow(SurfaceBatch& batch, Vec3f* radiance) {
  std::fill_n(memory_.is_gone, batch.count, false);
  std::uint64_t traced = 0;
  for (std::uint32_t depth = 0; depth < kSpecularDepthMax; ++depth) {
    const int count = scatter(batch, depth);
    if (count == 0) break;
    trace(part(count), batch, radiance);
    if (context_.is_over()) return traced;
    traced += static_cast<std::uint64_t>(count);
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

int SpecularChain::group_end(int first, int count) const {
  const std::uint64_t group = memory_.group[memory_.order[first]];
  int end = first + 1;
  while (end < count && memory_.group[memory_.order[end]] == group) ++end;
  return end;
}

// Parts the rays into packets: a group that may be a bundle begins one, and small ones share.
// Returns: how many packets there are.
int SpecularChain::part(int count) {
  int packet = 0;
  bool was_small = true;
  memory_.begin[0] = 0;
  for (int first = 0, end = 0; first < count; first = end) {
    end = group_end(first, count);
    const bool is_small = end - first < kCompanyLeast;
    if (first > 0 && !(is_small && was_small)) memory_.begin[++packet] = first;
    was_small = is_small;
    while (end - memory_.begin[packet] > kPacketRays) {
      memory_.begin[packet + 1] = memory_.begin[packet] + kPacketRays;
      ++packet;
    }
  }
  memory_.begin[++packet] = count;
  return packet;
}

void SpecularChain::trace(int packets, SurfaceBatch& batch, Vec3f* radiance) {
  for (int first = 0; first < packets && !context_.is_over(); first += RayList::kPacketsMax) {
    const int end = std::min(packets, first + RayList::kPacketsMax);
    const auto numbers = [&](int p) { return memory_.order + memory_.begin[p]; };
    const auto size = [&](int p) { return memory_.begin[p + 1] - memory_.begin[p]; };
    memory_.list.clear();
    for (int p = first; p < end; ++p) rays_.put(numbers(p), size(p), memory_.list, p - first);
    rays_.trace(memory_.list);
    for (int p = first; p < end; ++p)
      meet(rays_.take(memory_.list, p - first, numbers(p)), numbers(p), size(p), batch, radiance);
  }
}

// The surfaces that the packet at hand meets take the places of those that its rays have left.
void SpecularChain::meet(std::uint64_t met, const int* numbers, int n, SurfaceBatch& batch,
                         Vec3f* radiance) {
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
