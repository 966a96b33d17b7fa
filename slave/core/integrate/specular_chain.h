// SPDX-License-Identifier: Apache-2.0
// Follows rays through mirrors and glass to the surfaces behind. Each specular surface of a batch
// is replaced by the first one behind it that is not specular, with the throughput of the chain in
// its weight; emission on the way, and the sky at its end, are added to the pixel. Chains do not
// depend on the renderer: direct light, paths and gathering all follow them where a scene has
// specular surfaces, and then see none.
//
// All rays of a batch are traced by one call, those that leave one surface (instance and material)
// in one way (reflected or refracted) side by side, in the order of the batch, since they may look
// alike (traverse/many_call-inl.h). The result does not depend on that.
//
// Depth. At most kSpecularDepthMax reflections and refractions in a row, counted apart from
// `bounces`, which are those of surfaces that are not specular; deeper chains are black. Glass
// reflects or refracts by chance, so a chain is one ray; its random numbers depend on pixel, sample
// and depth alone.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>

#include "slave/core/integrate/scattered_rays.h"

namespace tessera::core {

// 16 is enough to go in and out of four glasses one behind another, reflected once within each. In
// a room of mirrors whose reflectance is 0.9, the light that is cut off has a weight of 0.9^16 =
// 0.19.
inline constexpr int kSpecularDepthMax = 16;

class SpecularChain {
 public:
  struct Memory {
    ScatteredRays::Memory rays;
    int order[kBatchMax];            // of rays; those of one group are neighbours
    std::uint64_t group[kBatchMax];  // by ray; rays of one group look alike
    int begin[kBatchMax + 1];        // place in `order`, by packet, and the end
    RayList list;                    // packets that are traced by one call
    bool is_gone[kBatchMax];         // by surface: its chain has ended
  };

  // Requires: both outlive it. `is_seen`: chains begin at what the camera sees.
  SpecularChain(const RenderContext& context, Memory& memory, bool is_seen = true)
      : context_(context), memory_(memory), is_seen_(is_seen), rays_(context, memory.rays) {}

  // Replaces the specular surfaces of the batch. Surfaces that are left keep their order, pixel and
  // key. Requires: batch.key is set. Returns: rays traced.
  std::uint64_t follow(SurfaceBatch& batch, Vec3f* radiance);

 private:
  int scatter(const SurfaceBatch& batch, std::uint32_t depth);
  int part(int count);
  int group_end(int first, int count) const;
  void trace(int packets, SurfaceBatch& batch, Vec3f* radiance);
  void meet(std::uint64_t met, const int* numbers, int n, SurfaceBatch& batch, Vec3f* radiance);

  const RenderContext& context_;
  Memory& memory_;
  const bool is_seen_;
  ScatteredRays rays_;
};

}  // namespace tessera::core
