// SPDX-License-Identifier: Apache-2.0
#include "slave/core/trace/scene_tracer.h"

#include <algorithm>
#include <limits>

#include "slave/core/ray/ray_bits.h"
#include "slave/core/trace/alpha_surfaces.h"
#include "slave/core/trace/ray_groups.h"

namespace tessera::core {
namespace {

SingleRay ray_of(const FanPacket& rays, int i) {
  return {{rays.origin[0], rays.origin[1], rays.origin[2]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          rays.t_min,
          rays.t_max[i]};
}

SingleRay ray_of(const RayPacket& rays, int i) {
  return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          rays.t_min[i],
          rays.t_max[i]};
}

// The directions and active bits of one of the fans.
void fill(const FanTargets& targets, int g, FanPacket& packet) {
  const int begin = targets.group[g], count = targets.group[g + 1] - begin;
  packet.active = bits_below(count);
  for (int i = 0; i < count; ++i) {
    for (int a = 0; a < 3; ++a)
      packet.direction[a][i] = targets.direction[a][targets.order[begin + i]];
  }
}

SingleRay ray_of(const ShadowFans& fans, int g, int i) {
  const FanTargets& targets = *fans.targets;
  const auto number = static_cast<std::size_t>(targets.order[targets.group[g] + i]);
  const std::uint32_t at_end =
      fans.excluded_at_end == nullptr ? kNoPrimitive : fans.excluded_at_end[number];
  return {
      {fans.origin[0], fans.origin[1], fans.origin[2]},
      {targets.direction[0][number], targets.direction[1][number], targets.direction[2][number]},
      fans.t_min,
      fans.t_max,
      {at_end, fans.excluded_at_origin}};
}

// Bits of the rays of a packet that are blocked.
template <class Packet>
std::uint64_t blocked_of(const Packet& rays, const MethodTracer& tracer) {
  std::uint64_t blocked = 0;
  for_each_ray(rays.active,
               [&](int i) { blocked |= std::uint64_t{tracer.occluded(ray_of(rays, i))} << i; });
  return blocked;
}

template <class Packet>
void trace_alone(const Packet& rays, const MethodTracer& tracer, PacketHits& hits) {
  for (int i = 0; i < kPacketRays; ++i) {
    hits.t[i] = 0;
    hits.primitive[i] = kNoPrimitive;
  }
  for_each_ray(rays.active, [&](int i) {
    const SingleHit hit = tracer.closest(ray_of(rays, i));
    hits.t[i] = hit.t;
    hits.primitive[i] = hit.primitive;
  });
}

std::uint64_t bits_of_met(std::uint64_t active, const PacketHits& hits) {
  std::uint64_t met = 0;
  for (; active != 0; active &= active - 1) {
    const int i = std::countr_zero(active);
    if (hits.primitive[i] != kNoPrimitive) met |= std::uint64_t{1} << i;
  }
  return met;
}

}  // namespace

// A hit at exactly the same t behind the one that is passed is passed, too: two sheets that lie in
// one place are one sheet.
void SceneTracer::go_through(SingleRay ray, SingleHit& hit) const {
  while (hit.primitive != kNoPrimitive && alpha_->is_passed(hit, ray, patch_method_)) {
    ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
    hit = nearest(ray);
  }
}

template <class Packet>
void SceneTracer::go_through_all(const Packet& rays, PacketHits& hits) const {
  for (std::uint64_t left = rays.active; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    if (hits.primitive[i] == kNoPrimitive) continue;
    SingleHit hit{hits.t[i], hits.primitive[i]};
    go_through(ray_of(rays, i), hit);
    hits.t[i] = hit.t;
    hits.primitive[i] = hit.primitive;
  }
}

void SceneTracer::go_through(const FanPacket& rays, PacketHits& hits) const {
  go_through_all(rays, hits);
}
void SceneTracer::go_through(const RayPacket& rays, PacketHits& hits) const {
  go_through_all(rays, hits);
}

void SceneTracer::by_method(const FanPacket& rays, PacketHits& hits) const {
  trace_alone(rays, *by_method_, hits);
  if (alpha_ != nullptr) go_through(rays, hits);
}
void SceneTracer::by_method(const RayPacket& rays, PacketHits& hits) const {
  trace_alone(rays, *by_method_, hits);
  if (alpha_ != nullptr) go_through(rays, hits);
}

std::uint64_t SceneTracer::stopped(const FanPacket& rays) const {
  if (alpha_ == nullptr) return blocked_of(rays, *by_method_);
  PacketHits hits;
  closest(rays, hits);
  return bits_of_met(rays.active, hits);
}
std::uint64_t SceneTracer::stopped(const RayPacket& rays) const {
  if (alpha_ == nullptr) return blocked_of(rays, *by_method_);
  PacketHits hits;
  closest(rays, hits);
  return bits_of_met(rays.active, hits);
}
void SceneTracer::stopped(const ShadowFans& fans, std::uint64_t* blocked) const {
  if (alpha_ == nullptr) {
    for (int g = 0; g < fans.targets->group_count; ++g) {
      blocked[g] = 0;
      const int count = fans.targets->group[g + 1] - fans.targets->group[g];
      for (int i = 0; i < count; ++i)
        blocked[g] |= std::uint64_t{by_method_->occluded(ray_of(fans, g, i))} << i;
    }
    return;
  }
  FanPacket packet;
  std::copy_n(fans.origin, 3, packet.origin);
  packet.t_min = fans.t_min;
  std::fill_n(packet.t_max, kPacketRays, fans.t_max);
  for (int g = 0; g < fans.targets->group_count; ++g) {
    fill(*fans.targets, g, packet);
    blocked[g] = stopped(packet);
  }
}

}  // namespace tessera::core
