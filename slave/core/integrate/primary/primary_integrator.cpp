// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/primary/primary_integrator.h"

namespace tessera::core {
namespace {

struct Distances {
  const TileParts& parts;
  const PacketHits& hits;
  PartPixels& pixels;

  void begin_sample(std::uint32_t) const {}
  void packet(int x, int y) const {
    const FanPacket& rays = parts.camera().rays;
    for (int i = 0; i < kPacketRays; ++i) {
      if (hits.primitive[i] == kNoPrimitive) continue;
      const Vec3f d{rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]};
      const float distance = hits.t[i] * length(d);
      Vec3f& sum = pixels.radiance[parts.pixel(x, y, i)];
      sum = sum + Vec3f{distance, distance, distance};
    }
  }
  void end_sample() const {}
};

}  // namespace

RayCounts PrimaryIntegrator::render(const RenderContext& context, const TileRect& rect,
                                    std::span<float> rgb) {
  TileParts parts(context);
  Distances distances{parts, hits_, pixels_};
  RayCounts counts;
  counts.primary = parts.render(distances, hits_, pixels_, rect, rgb);
  return counts;
}

}  // namespace tessera::core
