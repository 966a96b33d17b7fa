// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/workload.h"

#include <cmath>
#include <limits>

#include "common/math/bounds3.h"
#include "slave/core/camera/camera_rays.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::bench {
namespace {

constexpr int kBlockEdge = 32;

// Every second bit of a Morton number.
int every_second(int k) {
  int result = 0;
  for (int bit = 0; bit < 5; ++bit) result |= (k >> (2 * bit) & 1) << bit;
  return result;
}

void push(Workload& work, const RayStart& start, Vec3f direction, float t_max) {
  if (work.blocks.empty() || work.blocks.back().count == kBlockRays) work.blocks.emplace_back();
  RayBlock& block = work.blocks.back();
  for (int a = 0; a < 3; ++a) {
    block.origin[a][block.count] = start.point[a];
    block.direction[a][block.count] = direction[a];
  }
  const bool is_above = dot(start.normal, direction) > start.horizon * length(direction);
  block.excluded[block.count] = is_above ? start.primitive : core::kNoPrimitive;
  block.has_excluded |= is_above;
  block.t_max[block.count++] = t_max;
  ++work.ray_count;
}

// A cosine-distributed direction about n, from two numbers in [0, 1).
Vec3f cosine_direction(Vec3f n, Vec2f sample) {
  const float phi = 6.28318531f * sample.y, radius = std::sqrt(sample.x);
  const Vec3f other = std::fabs(n.x) > 0.5f ? Vec3f{0, 1, 0} : Vec3f{1, 0, 0};
  const Vec3f x = normalize(cross(other, n)), y = cross(n, x);
  return normalize(x * (radius * std::cos(phi)) + y * (radius * std::sin(phi)) +
                   n * std::sqrt(1 - sample.x));
}

}  // namespace

const char* ray_kind_name(RayKind kind) {
  static constexpr const char* kNames[] = {"primary", "shadow", "bounce"};
  return kNames[static_cast<int>(kind)];
}

Workload primary_rays(const Camera& camera, int size_px) {
  const core::CameraRays rays(camera, size_px, size_px);
  Workload work;
  for (int y = 0; y < size_px; y += kBlockEdge) {
    for (int x = 0; x < size_px; x += kBlockEdge) {
      for (int k = 0; k < kBlockRays; ++k) {
        const Vec3f d = rays.direction(x + every_second(k) + 0.5, y + every_second(k >> 1) + 0.5);
        push(work, {true, rays.origin(), {}}, normalize(d), std::numeric_limits<float>::infinity());
      }
    }
  }
  return work;
}

SecondaryRays secondary_rays(const Workload& primary, const std::vector<FirstHit>& hits,
                             const core::TriangleStore& triangles, Vec3f light) {
  Bounds3f box;
  for (std::uint64_t t = 0; t < triangles.primitive_count(); ++t) box.grow(triangles.vertex(t, 0));
  const float offset = 2e-5f * length(box.upper - box.lower);
  std::vector<RayStart> starts;
  starts.reserve(hits.size());
  for (const RayBlock& block : primary.blocks) {
    for (int i = 0; i < block.count; ++i) {
      const FirstHit& hit = hits[starts.size()];
      RayStart& start = starts.emplace_back();
      if (hit.primitive == core::kNoPrimitive) continue;
      const Vec3f d{block.direction[0][i], block.direction[1][i], block.direction[2][i]};
      const Vec3f o{block.origin[0][i], block.origin[1][i], block.origin[2][i]};
      const Vec3f a = triangles.vertex(hit.primitive, 0);
      Vec3f n = normalize(
          cross(triangles.vertex(hit.primitive, 1) - a, triangles.vertex(hit.primitive, 2) - a));
      if (dot(n, d) > 0) n = -n;
      start = {true, o + d * hit.t + n * offset, n};
    }
  }
  return secondary_rays(starts, light);
}

SecondaryRays secondary_rays(const std::vector<RayStart>& starts, Vec3f light) {
  SecondaryRays result;
  result.shadow.kind = RayKind::kShadow;
  result.bounce.kind = RayKind::kBounce;
  for (std::size_t number = 0; number < starts.size(); ++number) {
    const RayStart& start = starts[number];
    if (!start.is_hit) continue;
    push(result.shadow, start, light - start.point, 0.9999f);
    const Vec2f sample = core::sample_2d(core::mix_bits(static_cast<std::uint32_t>(number)), 0);
    push(result.bounce, start, cosine_direction(start.normal, sample),
         std::numeric_limits<float>::infinity());
  }
  return result;
}

}  // namespace tessera::bench
