// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/vpl_gather.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/math/rounding.h"
#include "slave/core/trace/ray_groups.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;
// End of shadow rays to points at 1. A reported t is off by up to 3 roundings (plane-inl.h), so
// that nothing that lies beyond 1 is hit.
constexpr float kEnd = 1 - 4 * kUnitRoundoff;

// Moves a far light to a place from which parallel rays to the points stand side by side.
void stand_back(const GatherPoints& points, LightPoint& light) {
  float extent = 0;
  for (int a = 0; a < 3; ++a) extent = std::max(extent, points.upper[a] - points.lower[a]);
  for (int a = 0; a < 3; ++a) {
    const float middle = 0.5f * (points.lower[a] + points.upper[a]);
    light.position[a] = middle - light.normal[a] * (4 * extent);
  }
}

}  // namespace

VplGather::VplGather(const RenderContext& context, GatherRays& memory, const GeometryBounds& bounds)
    : context_(context), rays_(memory), bounds_(bounds) {}

std::uint64_t VplGather::add(std::span<const LightPoint> vpls, std::size_t first,
                             std::size_t stride, float weight, GatherPoints& points) {
  std::uint64_t rays = 0;
  for (std::size_t i = first; i < vpls.size() && points.count > 0; i += stride) {
    if (context_.is_over()) break;
    LightPoint light = vpls[i];
    for (float& c : light.rgb) c *= weight * kInvPi;
    rays += add_one(light, points);
  }
  return rays;
}

std::uint64_t VplGather::add_one(LightPoint light, GatherPoints& points) {
  const KernelTable& kernels = context_.kernels();
  const bool is_far = light.kind == LightPointKind::kFar;
  if (is_far) stand_back(points, light);
  const float bound = light.kind == LightPointKind::kEmitter ? bounds_.emitter : bounds_.vpl;
  if (!kernels.begin_gather(points, light, bound, rays_)) return 0;
  kernels.group_fans(rays_.targets);
  if (is_far) {
    trace_parallel(light, points);
  } else {
    trace_fans(light);
  }
  kernels.end_gather(light, rays_, points);
  return static_cast<std::uint64_t>(rays_.targets.count);
}

// Takes the light from the points of a group's rays that are blocked.
void VplGather::darken(std::uint64_t blocked, int group) {
  const int* const order = rays_.targets.order + rays_.targets.group[group];
  for (; blocked != 0; blocked &= blocked - 1)
    rays_.strength[rays_.point[order[std::countr_zero(blocked)]]] = 0;
}

void VplGather::trace_fans(const LightPoint& light) {
  fans_.targets = &rays_.targets;
  for (int a = 0; a < 3; ++a) fans_.origin[a] = light.position[a];
  fans_.t_min = light.t_min;
  fans_.t_max = kEnd;
  fans_.excluded_at_origin = rays_.is_origin_excluded ? light.primitive : kNoPrimitive;
  fans_.excluded_at_end = rays_.excluded;
  context_.tracer.occluded(fans_, blocked_);
  for (int g = 0; g < rays_.targets.group_count; ++g) darken(blocked_[g], g);
}

// Traces shadow rays from the points towards the light.
void VplGather::trace_parallel(const LightPoint& light, const GatherPoints& points) {
  const FanTargets& targets = rays_.targets;
  const Vec3f direction{-light.normal[0], -light.normal[1], -light.normal[2]};
  for (int first = 0; first < targets.group_count; first += RayList::kPacketsMax) {
    const int groups = std::min(RayList::kPacketsMax, targets.group_count - first);
    list_.clear();
    for (int g = 0; g < groups; ++g) {
      const int begin = targets.group[first + g], end = targets.group[first + g + 1];
      for (int i = begin; i < end; ++i) {
        const int p = rays_.point[targets.order[i]];
        const Vec3f point{points.point[0][p], points.point[1][p], points.point[2][p]};
        const Vec3f normal{points.normal[0][p], points.normal[1][p], points.normal[2][p]};
        list_.put(g * kPacketRays + i - begin, point + normal * points.offset[p], direction);
        list_.exclude(g * kPacketRays + i - begin, rays_.excluded[targets.order[i]]);
      }
    }
    context_.tracer.occluded(list_.many(), blocked_);
    for (int g = 0; g < groups; ++g) darken(blocked_[g], first + g);
  }
}

}  // namespace tessera::core
