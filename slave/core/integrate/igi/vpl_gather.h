// SPDX-License-Identifier: Apache-2.0
// Light of VPLs at a batch of points. Shadow rays are traced for one VPL after the other; all of
// them leave the VPL, and they are grouped by where they go, seen from it (Benthin, thesis, section
// 9.3). A point sums over VPLs in their order, whatever its neighbours do.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "slave/core/integrate/render_context.h"
#include "slave/core/light/gather_layout.h"
#include "slave/core/ray/ray_list.h"

namespace tessera::core {

// Bounds of the geometry term of VPLs and of points on area lights; unit: 1 / area.
struct GeometryBounds {
  float vpl = std::numeric_limits<float>::infinity();
  float emitter = std::numeric_limits<float>::infinity();
  bool has_any() const { return vpl < std::numeric_limits<float>::infinity(); }
};

class VplGather {
 public:
  // Requires: context and memory outlive it.
  VplGather(const RenderContext& context, GatherRays& memory, const GeometryBounds& bounds);

  // Adds to points.light what every `stride`-th VPL from number `first` on sheds, times `weight`.
  // Requires: KernelTable::bound_points(points) was called after they last changed. Returns: shadow
  // rays traced.
  std::uint64_t add(std::span<const LightPoint> vpls, std::size_t first, std::size_t stride,
                    float weight, GatherPoints& points);

 private:
  std::uint64_t add_one(LightPoint light, GatherPoints& points);
  void trace_fans(const LightPoint& light);
  void trace_parallel(const LightPoint& light, const GatherPoints& points);
  void darken(std::uint64_t blocked, int group);

  const RenderContext& context_;
  GatherRays& rays_;
  const GeometryBounds bounds_;
  ShadowFans fans_;
  std::uint64_t blocked_[kFanTargetsMax];  // by fan
  RayList list_;
};

}  // namespace tessera::core
