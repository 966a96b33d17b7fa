// SPDX-License-Identifier: Apache-2.0
// What the bound of the VPLs' geometry term takes away, traced: a ray finds the surface nearby whose
// VPLs the bound would have weakened, and paths find its light (Kollig and Keller, "Illumination in
// the presence of weak singularities", 2004). VPLs within the bound and this together are unbiased.
//
// From a point x a ray of pdf cosine / pi meets y; of the light that y sends, the share
// 1 - bound / G(x, y) is what VPLs at y have lost, where G > bound. G is at most 1 / distance^2, so
// the ray is no longer than 1 / sqrt(bound).
//
// Threads. One object per thread; holds rays and paths as scratch memory.
#pragma once

#include <atomic>
#include <memory>

#include "common/frame/frame_stats.h"
#include "slave/core/integrate/igi/vpl_gather.h"
#include "slave/core/light/gather_layout.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

class BiasCompensation {
 public:
  BiasCompensation();
  ~BiasCompensation();

  // Keeps references until the next call. Requires: bounds.has_any(); that of
  // emitters is not below that of VPLs.
  void begin(const PreparedScene::Impl& scene, const SceneTracer& tracer,
             const GeometryBounds& bounds, int bounces, const std::atomic<bool>* is_cancelled);

  // Adds to points.light. sequence_index: of the pixels' samples. Requires: points.key is set.
  RayCounts add(GatherPoints& points, std::uint32_t sequence_index);

 private:
  struct Scratch;
  void follow(const GatherPoints& points, int first, int count);
  void arrive(const GatherPoints& points, int first);

  const PreparedScene::Impl* scene_ = nullptr;
  const SceneTracer* tracer_ = nullptr;
  GeometryBounds bounds_;
  int bounces_ = 0;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace tessera::core
