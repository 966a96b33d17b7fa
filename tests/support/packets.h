// SPDX-License-Identifier: Apache-2.0
// Traces rays in packets of 64 and alone, through everything that a renderer would use. Packets are
// filled in the given order, so that a test chooses a ray's companions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/primitive/triangle/barycentric.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/reference_tracer.h"

namespace tessera::test {

struct Hit {
  std::uint32_t primitive = core::kNoPrimitive;
  float t = 0, u = 0, v = 0;
  bool is_hit() const { return primitive != core::kNoPrimitive; }
  bool operator==(const Hit&) const = default;
};

inline Hit make_hit(const core::TriangleStore& triangles, const Ray& ray, std::uint32_t primitive,
                    float t) {
  if (primitive == core::kNoPrimitive) return {primitive, t, 0, 0};
  const Vec2f uv =
      core::barycentric(ray.origin, ray.direction, triangles.vertex(primitive, 0),
                        triangles.vertex(primitive, 1), triangles.vertex(primitive, 2));
  return {primitive, t, uv.x, uv.y};
}

// A packet of rays from `first` on; the packet's other rays are inactive.
inline core::RayPacket make_packet(const std::vector<Ray>& rays, std::size_t first) {
  core::RayPacket packet{};
  const std::size_t count = std::min<std::size_t>(core::kPacketRays, rays.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    const Ray& ray = rays[first + i];
    for (int a = 0; a < 3; ++a) {
      packet.origin[a][i] = ray.origin[a];
      packet.direction[a][i] = ray.direction[a];
    }
    packet.t_min[i] = ray.t_min;
    packet.t_max[i] = ray.t_max;
    packet.active |= std::uint64_t{1} << i;
  }
  return packet;
}

inline std::vector<Hit> trace_packets(const core::KernelTable& kernels,
                                      const core::PreparedScene::Impl& scene,
                                      const std::vector<Ray>& rays) {
  const core::SceneTracer tracer(scene.index, kernels);
  std::vector<Hit> hits;
  for (std::size_t first = 0; first < rays.size(); first += core::kPacketRays) {
    core::PacketHits found;
    tracer.closest(make_packet(rays, first), found);
    for (std::size_t i = 0; i < core::kPacketRays && first + i < rays.size(); ++i) {
      hits.push_back(make_hit(scene.triangles, rays[first + i], found.primitive[i], found.t[i]));
    }
  }
  return hits;
}

inline Hit trace_single(const core::KernelTable& kernels, const core::PreparedScene::Impl& scene,
                        const Ray& ray) {
  const Vec3f o = ray.origin, d = ray.direction;
  const core::SingleHit hit =
      core::SceneTracer(scene.index, kernels)
          .closest({{o.x, o.y, o.z}, {d.x, d.y, d.z}, ray.t_min, ray.t_max});
  return make_hit(scene.triangles, ray, hit.primitive, hit.t);
}

// Instruction sets to test here: all that this CPU has.
inline std::vector<Isa> isas_here() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::kScalar, Isa::kSse4, Isa::kAvx2, Isa::kAvx512}) {
    if ((core::supported_isas() & isa_bit(isa)) != 0) isas.push_back(isa);
  }
  return isas;
}

}  // namespace tessera::test
