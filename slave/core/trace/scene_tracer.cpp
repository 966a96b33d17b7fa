// SPDX-License-Identifier: Apache-2.0
#include "slave/core/trace/scene_tracer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "slave/core/ray/ray_bits.h"
#include "slave/core/ray/ray_list.h"
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

SingleRay ray_of(const ManyRays& rays, int i) {
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

// Calls `function(packet, i)` for each ray, the one in place i.
template <class Function>
void for_each_of(const ManyRays& rays, const Function& function) {
  for (int p = 0; p < rays.packet_count; ++p)
    for_each_ray(rays.active[p], [&](int i) { function(p, p * kPacketRays + i); });
}
template <class Function>
void for_each_of(const FanPacket& rays, const Function& function) {
  for_each_ray(rays.active, [&](int i) { function(0, i); });
}

void put(const SingleHit& hit, int i, const HitArrays& hits) {
  hits.t[i] = hit.t;
  hits.primitive[i] = hit.primitive;
}

// packet_count: of `rays`.
template <class Rays>
void trace_alone(const Rays& rays, int packet_count, const MethodTracer& tracer,
                 const HitArrays& hits) {
  for (int i = 0; i < packet_count * kPacketRays; ++i) put({0, kNoPrimitive}, i, hits);
  for_each_of(rays, [&](int, int i) { put(tracer.closest(ray_of(rays, i)), i, hits); });
}

}  // namespace

// Rays that go through what they have hit, and their places in the arrays of the caller.
struct PassingRays {
  static constexpr int kMost = RayList::kRaysMax;

  // Adds a ray that goes through what is at t.
  void add(int at, const SingleRay& ray, float t) {
    next->put(count, {ray.origin[0], ray.origin[1], ray.origin[2]},
              {ray.direction[0], ray.direction[1], ray.direction[2]}, ray.t_max,
              std::nextafter(t, std::numeric_limits<float>::infinity()));
    place[count++] = at;
  }
  // Begins a list anew. Returns: the one before.
  const RayList& take() {
    std::swap(list, next);
    next->clear();
    count = 0;
    return *list;
  }

  int count = 0;  // in the next list
  int place[kMost];
  RayList lists[2];
  RayList *list = &lists[0], *next = &lists[1];
  ListHits found;
};

// A hit at exactly the same t behind the one that is passed is passed, too: two sheets that lie in
// one place are one sheet.
void SceneTracer::go_through(SingleRay ray, SingleHit& hit) const {
  while (hit.primitive != kNoPrimitive && alpha_->is_passed(hit, ray, patch_method_)) {
    ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
    hit = nearest(ray);
  }
}

// What is behind a surface is asked for all rays that go through one by one call.
template <class Rays>
void SceneTracer::go_through_all(const Rays& rays, const HitArrays& hits) const {
  PassingRays passing;
  for_each_of(rays, [&](int, int i) {
    const SingleHit hit{hits.t[i], hits.primitive[i]};
    if (hit.primitive == kNoPrimitive) return;
    const SingleRay ray = ray_of(rays, i);
    if (!alpha_->is_passed(hit, ray, patch_method_)) return;
    passing.add(i, ray, hit.t);
    if (passing.count == PassingRays::kMost) go_behind(passing, hits);
  });
  go_behind(passing, hits);
}
// Takes the rays to what they do not go through. None is left.
void SceneTracer::go_behind(PassingRays& passing, const HitArrays& hits) const {
  while (passing.count > 0) {
    const int count = passing.count;
    const ManyRays rays = passing.take().many();
    nearest(rays, passing.found.arrays());
    for (int k = 0; k < count; ++k) {
      const SingleHit hit{passing.found.t[k], passing.found.primitive[k]};
      const int i = passing.place[k];
      put(hit, i, hits);
      if (hit.primitive == kNoPrimitive) continue;
      const SingleRay ray = ray_of(rays, k);
      if (alpha_->is_passed(hit, ray, patch_method_)) passing.add(i, ray, hit.t);
    }
  }
}
void SceneTracer::go_through(const FanPacket& rays, const HitArrays& hits) const {
  go_through_all(rays, hits);
}
void SceneTracer::go_through(const ManyRays& rays, const HitArrays& hits) const {
  go_through_all(rays, hits);
}

void SceneTracer::by_method(const FanPacket& rays, PacketHits& hits) const {
  trace_alone(rays, 1, *by_method_, arrays_of(hits));
  if (alpha_ != nullptr) go_through(rays, arrays_of(hits));
}
void SceneTracer::nearest(const ManyRays& rays, const HitArrays& hits) const {
  if (is_by_method()) return trace_alone(rays, rays.packet_count, *by_method_, hits);
  std::visit([&](const auto& v) { table(v).closest_many(v, rays, hits); }, view_);
}

std::uint64_t SceneTracer::stopped(const FanPacket& rays) const {
  std::uint64_t blocked = 0;
  if (alpha_ == nullptr) {
    for_each_of(rays, [&](int, int i) {
      blocked |= std::uint64_t{by_method_->occluded(ray_of(rays, i))} << i;
    });
    return blocked;
  }
  PacketHits hits;
  closest(rays, hits);
  for_each_of(
      rays, [&](int, int i) { blocked |= std::uint64_t{hits.primitive[i] != kNoPrimitive} << i; });
  return blocked;
}
void SceneTracer::stopped(const ManyRays& rays, std::uint64_t* blocked) const {
  std::fill_n(blocked, rays.packet_count, std::uint64_t{0});
  if (alpha_ == nullptr) {
    for_each_of(rays, [&](int p, int i) {
      blocked[p] |= std::uint64_t{by_method_->occluded(ray_of(rays, i))} << i % kPacketRays;
    });
    return;
  }
  ListHits hits;
  for (int first = 0; first < rays.packet_count; first += RayList::kPacketsMax) {
    const int count = std::min(RayList::kPacketsMax, rays.packet_count - first);
    const ManyRays some = packets_from(rays, first, count);
    closest(some, hits.arrays());
    for_each_of(some, [&](int p, int i) {
      const bool is_blocked = hits.primitive[i] != kNoPrimitive;
      blocked[first + p] |= std::uint64_t{is_blocked} << i % kPacketRays;
    });
  }
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
