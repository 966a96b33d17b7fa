// SPDX-License-Identifier: Apache-2.0
// The rays that are traced: camera rays, shadow rays to a point light and diffuse bounces, in
// blocks of 32x32 pixels in Morton order, so that 4, 8, 16 consecutive camera rays are 2x2, 4x2,
// 4x4 pixels. Secondary rays start where the camera rays have hit and stand in their order, misses
// left out.
//
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/horizon_layout.h"
#include "slave/core/ray/packet_layout.h"
#include "tests/bench/scenes.h"

namespace tessera::bench {

enum class RayKind { kPrimary, kShadow, kBounce };
inline constexpr int kRayKinds = 3;
const char* ray_kind_name(RayKind kind);

inline constexpr int kBlockRays = 1024;

// P(t) = origin + t * direction, 0 <= t <= t_max; a shadow ray ends at the light for t = 1.
struct alignas(64) RayBlock {
  float origin[3][kBlockRays];
  float direction[3][kBlockRays];
  float t_max[kBlockRays];
  std::uint32_t excluded[kBlockRays];  // as core::ManyRays has them; where has_excluded
  int count = 0;
  bool has_excluded = false;
};

struct Workload {
  RayKind kind = RayKind::kPrimary;
  std::vector<RayBlock> blocks;
  std::uint64_t ray_count = 0;
};

// size_px: a multiple of 32.
Workload primary_rays(const Camera& camera, int size_px);

struct SecondaryRays {
  Workload shadow, bounce;
};
// What a primary ray has hit.
struct FirstHit {
  float t;
  std::uint32_t primitive;
};
// hits: one for each primary ray, in their order. The directions of bounces are cosine-distributed,
// from a fixed sequence.
SecondaryRays secondary_rays(const Workload& primary, const std::vector<FirstHit>& hits,
                             const core::TriangleStore& triangles, Vec3f light);

// Where secondary rays start; the normal is on the side that the primary ray has come from.
struct RayStart {
  bool is_hit = false;
  Vec3f point, normal;
  std::uint32_t primitive = core::kNoPrimitive;  // that is not met again above `horizon`
  float horizon = core::kNoHorizon;
};
// The same for starts that the caller has found, one for each primary ray.
SecondaryRays secondary_rays(const std::vector<RayStart>& starts, Vec3f light);

}  // namespace tessera::bench
