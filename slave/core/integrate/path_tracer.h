// SPDX-License-Identifier: Apache-2.0
// Light that reaches surfaces over others, without bias: the reference that faster renderers are
// measured against. Paths begin at what the camera sees; at each surface one sample of one emitter,
// one of the sky's picture and every delta light add what they shed, then the path goes on in a direction that the
// BSDF chooses (Kajiya, "The rendering equation", 1986; light samples as in direct_light.h). No path
// is ended by chance: `bounces` bounds them.
//
// Who counts an emitter, or the map of a sky: both a light sample and the path's own ray, each by its
// MIS weight (Veach and Guibas, "Optimally combining sampling techniques", 1995, the
// balance heuristic); behind mirrors and glass the ray alone. Delta lights are not seen in
// mirrors and shed nothing through glass: no path finds them there.
//
// Bounces are those of diffuse and glossy surfaces. Mirrors and glass between them have a depth of
// their own (specular_chain.h).
//
// A path's numbers depend on its pixel, sample and depth alone.
//
// Threads. One object per thread; holds rays as scratch memory.
#pragma once

#include <atomic>
#include <memory>

#include "common/frame/frame_stats.h"
#include "slave/core/integrate/direct_light.h"
#include "slave/core/integrate/specular_chain.h"

namespace tessera::core {

class PathTracer {
 public:
  PathTracer() : rays_(std::make_unique<ScatteredRays>()) {}

  // Keeps references until the next call. Requires: all outlive the calls of add(). `is_cancelled`
  // may be null; when it turns true, add() stops within a bounce.
  void begin(const PreparedScene::Impl& scene, const SceneTracer& tracer, int bounces,
             const std::atomic<bool>* is_cancelled);

  // Adds what the surfaces reflect to radiance [pixel]. Changes the batch. Requires: no surface is
  // specular. Returns: rays traced.
  RayCounts add(SurfaceBatch& batch, Vec3f* radiance);

 private:
  bool is_over() const {
    return is_cancelled_ != nullptr && is_cancelled_->load(std::memory_order_relaxed);
  }
  void scatter(const SurfaceBatch& batch, std::uint32_t depth);
  void add_sky(int first, std::uint64_t open, Vec3f* radiance) const;
  std::uint64_t follow(SurfaceBatch& batch, Vec3f* radiance);

  const PreparedScene::Impl* scene_ = nullptr;
  const SceneTracer* tracer_ = nullptr;
  int bounces_ = 0;
  const std::atomic<bool>* is_cancelled_ = nullptr;
  DirectLight direct_;
  SpecularChain chain_;
  std::unique_ptr<ScatteredRays> rays_;
};

}  // namespace tessera::core
