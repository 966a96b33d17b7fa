// SPDX-License-Identifier: Apache-2.0
// Unbiased path tracing: the reference that faster renderers are measured against. Paths begin at
// the surfaces that the camera sees. At each surface one sample of one emitter, one of the
// environment map and every delta light add what they shed; then the path goes on in a direction
// that the BSDF chooses (Kajiya, "The rendering equation", 1986; light samples as in
// direct_light.h). There is no Russian roulette: `bounces` bounds the paths.
//
// An emitter, or an environment map, is counted by both a light sample and the path's own ray, each
// with its MIS weight (Veach and Guibas, "Optimally combining sampling techniques", 1995, the
// balance heuristic); behind mirrors and glass it is counted by the ray alone. Delta lights are not
// seen in mirrors and shed nothing through glass: no path finds them there.
//
// Bounces are those of diffuse and glossy surfaces. Mirrors and glass between them have a depth of
// their own (specular_chain.h).
//
// A path's random numbers depend on its pixel, sample and depth alone.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include "common/frame/frame_stats.h"
#include "slave/core/integrate/direct_light.h"
#include "slave/core/integrate/specular_chain.h"

namespace tessera::core {

class PathTracer {
 public:
  struct Memory {
    DirectLight::Memory direct;
    SpecularChain::Memory chain;
    ScatteredRays::Memory rays;
  };

  // Requires: context and memory outlive it.
  PathTracer(const RenderContext& context, Memory& memory, int bounces)
      : context_(context),
        bounces_(bounces),
        direct_(context, memory.direct, DirectLight::Kind::kPartOfPath),
        chain_(context, memory.chain, /*is_seen=*/false),
        rays_(context, memory.rays) {}

  // Adds what the surfaces reflect to radiance [pixel]. Changes the batch. Requires: no surface is
  // specular. Returns: rays traced. Stops within a bounce once the context is over.
  RayCounts add(SurfaceBatch& batch, Vec3f* radiance);

 private:
  void scatter(const SurfaceBatch& batch, std::uint32_t depth);
  void add_sky(int first, std::uint64_t open, Vec3f* radiance);
  std::uint64_t follow(SurfaceBatch& batch, Vec3f* radiance);

  const RenderContext& context_;
  const int bounces_;
  DirectLight direct_;
  SpecularChain chain_;
  ScatteredRays rays_;
};

}  // namespace tessera::core
