// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/igi/bias_compensation.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/math/rounding.h"
#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/integrate/own_primitive.h"
#include "slave/core/sampling/dimension.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

// The geometry term is computed with a few roundings, and a direction's length is 1 but for some
// more. What exceeds the bound by no more than these is still to be met.
constexpr float kReachSlack = 64 * kUnitRoundoff;

static_assert(kPacketRays <= kSamplePoints && kPacketRays <= BsdfPacket::kMax);

}  // namespace

BiasCompensation::BiasCompensation(const RenderContext& context, Memory& memory,
                                   const GeometryBounds& bounds)
    : context_(context),
      memory_(memory),
      bounds_(bounds),
      reach_(1 / std::sqrt(bounds.vpl)),
      met_(context.scene, context.tracer, memory.met),
      paths_(context, memory.paths, std::max(0, context.settings.bounces - 1)) {
  memory.batch.make_room_for_lobes(context.scene.features.has_lobes);
  memory.arrived.make_room_for_lobes(context.scene.features.has_lobes);
}

RayCounts BiasCompensation::add(GatherPoints& points, std::uint32_t sequence_index) {
  Memory& s = memory_;
  RayCounts counts;
  s.batch.count = 0;
  s.batch.sample_index = sequence_index;
  std::fill_n(s.light, points.count, Vec3f{});
  s.list.clear();
  for (int first = 0; first < points.count; first += kPacketRays)
    put_rays(points, first, std::min(kPacketRays, points.count - first));
  context_.tracer.closest(s.list.many(), s.found.arrays());
  for (int p = 0; p < s.list.packet_count(); ++p) {
    s.list.copy_packet(p, s.rays);
    s.found.copy_packet(p, s.hits);
    met_.find(s.rays, s.hits);
    arrive(points, p * kPacketRays);
    counts.secondary += static_cast<std::uint64_t>(std::popcount(s.rays.active));
  }
  if (context_.settings.bounces > 0 && s.batch.count > 0) counts += paths_.add(s.batch, s.light);
  for (int i = 0; i < points.count; ++i) {
    for (int c = 0; c < 3; ++c) points.light[c][i] += s.light[i][c];
  }
  return counts;
}

// Puts the rays of `count` points from number `first` on into the list.
void BiasCompensation::put_rays(const GatherPoints& points, int first, int count) {
  Memory& s = memory_;
  s.samples.count = count;
  std::copy_n(points.key + first, count, s.samples.key);
  context_.kernels().sample_points(dimension(Dimension::kBiasRay), s.batch.sample_index, s.samples);
  s.directions.clear();
  for (int i = 0; i < count; ++i) {
    const int p = first + i;
    s.directions.add_diffuse({points.shading[0][p], points.shading[1][p], points.shading[2][p]},
                             {s.samples.square[0][i], s.samples.square[1][i]});
  }
  s.directions.sample_diffuse(context_.kernels());
  for (int i = 0; i < count; ++i) {
    const int p = first + i;
    const Vec3f normal{points.normal[0][p], points.normal[1][p], points.normal[2][p]};
    const Vec3f direction = s.directions.direction(i);
    const Vec3f shading{points.shading[0][p], points.shading[1][p], points.shading[2][p]};
    const float cosine = dot(shading, direction);
    if (!(dot(direction, normal) > 0 && cosine > 0)) continue;
    const Vec3f point{points.point[0][p], points.point[1][p], points.point[2][p]};
    s.list.put(p, point + normal * points.offset[p], direction,
               std::min(reach_, reach_ * std::sqrt(cosine) * (1 + kReachSlack)));
    exclude_own(s.list, p, {points.primitive[p], points.horizon[p]}, normal, direction);
  }
}

// Handles the hits of the packet whose first ray is that of point number `first`.
void BiasCompensation::arrive(const GatherPoints& points, int first) {
  Memory& s = memory_;
  const PacketPoints& at = met_.points();
  float geometry[kPacketRays];
  std::uint64_t beyond = 0;  // rays whose light the bound has weakened
  for (std::uint64_t left = at.met; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left), p = first + i;
    const Vec3f shading{points.shading[0][p], points.shading[1][p], points.shading[2][p]};
    const Vec3f normal{at.normal[0][i], at.normal[1][i], at.normal[2][i]};
    const Vec3f direction{s.rays.direction[0][i], s.rays.direction[1][i], s.rays.direction[2][i]};
    geometry[i] =
        dot(shading, direction) * -dot(normal, direction) / (at.distance[i] * at.distance[i]);
    if (geometry[i] > bounds_.vpl) beyond |= std::uint64_t{1} << i;
  }
  Surface* to[kPacketRays];
  for (int i = 0; i < kPacketRays; ++i) to[i] = &s.arrived.surface[i];
  met_.make(s.rays, s.hits, beyond, nullptr, to, &s.arrived);
  for (; beyond != 0; beyond &= beyond - 1) {
    const int i = std::countr_zero(beyond), p = first + i;
    Surface& y = s.arrived.surface[i];
    if (geometry[i] > bounds_.emitter)
      s.light[p] = s.light[p] + y.emission * (1 - bounds_.emitter / geometry[i]);
    if (is_specular(y)) continue;  // no VPL is there
    y.weight = y.weight * (1 - bounds_.vpl / geometry[i]);
    SurfaceBatch& batch = s.batch;
    s.arrived.key[i] = hash_combine(points.key[p], dimension(Dimension::kBiasPath));
    s.arrived.pixel[i] = static_cast<std::uint16_t>(p);
    batch.add(s.arrived, i);
  }
}

}  // namespace tessera::core
