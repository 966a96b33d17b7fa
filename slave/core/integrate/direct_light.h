// SPDX-License-Identifier: Apache-2.0
// Light that reaches a batch of surface points straight from the scene's lights.
//
// Shadow rays are traced in groups that look alike from the light, whatever pixels they belong to.
// A glossy surface takes what a light sample finds by its MIS weight (balance heuristic); the rest
// of that light comes with the next ray of the path, or with GlossyLight. As a part of paths, so do diffuse
// surfaces: a lamp next to a corner would else have a variance without bound.
//
// Sums run over lights, then emitters, then samples, in that order and per pixel alone: a pixel
// does not depend on its neighbours.
//
// Threads. One object per thread; holds the shadow rays as scratch memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "slave/core/integrate/glossy_light.h"
#include "slave/core/scene/surface_batch.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

class DirectLight {
 public:
  DirectLight();
  ~DirectLight();

  // What a part of longer paths needs is one sample of one emitter, picked by power, and not an even
  // sky, which their own rays meet.
  enum class Kind { kWhole, kPartOfPath };

  // Keeps references until the next call. Requires: all outlive the calls of add().
  // `is_cancelled` may be null; when it turns true, add() stops at the next light or sample.
  void begin(const PreparedScene::Impl& scene, const SceneTracer& tracer, int light_samples,
             Kind kind, const std::atomic<bool>* is_cancelled = nullptr);

  // Adds reflected direct light to radiance [pixel]. Requires: no surface is specular. Returns:
  // rays traced towards lights.
  std::uint64_t add(const SurfaceBatch& batch, Vec3f* radiance);

 private:
  struct ShadowRays;

  bool is_over() const {
    return is_cancelled_ != nullptr && is_cancelled_->load(std::memory_order_relaxed);
  }
  std::uint64_t add_directional(const SurfaceBatch& batch, const Light& light, Vec3f* radiance);
  std::uint64_t add_point(const SurfaceBatch& batch, const Light& light, Vec3f* radiance);
  std::uint64_t add_emitters(const SurfaceBatch& batch, Vec3f* radiance);
  std::uint64_t add_environment(const SurfaceBatch& batch, Vec3f* radiance);
  std::uint64_t trace_groups(const SurfaceBatch& batch, Vec3f* radiance);
  void add_open(const SurfaceBatch& batch, int surface, Vec3f* radiance) const;

  const PreparedScene::Impl* scene_ = nullptr;
  const SceneTracer* tracer_ = nullptr;
  int light_samples_ = 1;
  bool picks_emitters_ = false;
  Feature samples_environment_{}, samples_glossy_{};
  const std::atomic<bool>* is_cancelled_ = nullptr;
  std::unique_ptr<ShadowRays> rays_;
  GlossyLight glossy_;
};

}  // namespace tessera::core
