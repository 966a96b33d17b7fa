// SPDX-License-Identifier: Apache-2.0
// Bias compensation: path-traces the light that the bound of the VPLs' geometry term takes away. A
// ray finds the surface nearby whose VPLs the bound would have weakened, and paths find that
// surface's light (Kollig and Keller, "Illumination in the presence of weak singularities", 2004).
// VPLs within the bound and this together are unbiased.
//
// From a point x a ray of pdf cosine / pi meets y; of the light that y sends, the share
// 1 - bound / G(x, y) is what VPLs at y have lost, where G > bound. G is at most the cosine at x
// over distance^2, so the ray is no longer than sqrt(cosine / bound).
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include "common/frame/frame_stats.h"
#include "slave/core/integrate/igi/vpl_gather.h"
#include "slave/core/integrate/path/path_tracer.h"
#include "slave/core/light/gather_layout.h"
#include "slave/core/ray/ray_list.h"

namespace tessera::core {

class BiasCompensation {
 public:
  struct Memory {
    PathTracer::Memory paths;
    SurfaceBatch batch;  // what the rays have met; pixel: number of the point
    Vec3f light[kGatherMax];
    SamplePoints samples{};
    BsdfPacket directions;
    RayList list;  // by number of the point
    ListHits found;
    RayPacket rays;  // that are looked at
    PacketHits hits;
    MetSurfaces::Memory met;
    SurfaceBatch arrived;  // surfaces that one packet has met
  };

  // Requires: context and memory outlive it; bounds.has_any(); bounds.emitter >= bounds.vpl.
  BiasCompensation(const RenderContext& context, Memory& memory, const GeometryBounds& bounds);

  // Adds the compensation to points.light. sequence_index: that of the pixels' samples. Requires:
  // points.key is set.
  RayCounts add(GatherPoints& points, std::uint32_t sequence_index);

 private:
  void put_rays(const GatherPoints& points, int first, int count);
  void arrive(const GatherPoints& points, int first);

  const RenderContext& context_;
  Memory& memory_;
  const GeometryBounds bounds_;
  const float reach_;  // of a ray along the normal
  MetSurfaces met_;
  PathTracer paths_;
};

}  // namespace tessera::core
