// SPDX-License-Identifier: Apache-2.0
// Through mirrors and glass to the surfaces behind: of a batch, each surface that is specular is
// replaced by the first one that is not, with the weight of what it sends; whatever emits on the
// way, and the sky at its end, is added to the pixel. Independent of the renderer: direct light,
// paths and gathering all ask for it where a scene has such surfaces, and then know of none.
//
// Rays are traced together that leave one surface (instance and material) in one way (reflected or
// refracted), in the order of the batch; what is no narrow bundle is traced ray by ray, as any packet
// (traverse/packet_call-inl.h). An answer does not depend on that.
//
// Depth. At most kSpecularDepthMax reflections and refractions in a row, counted apart from
// `bounces`, which are those of surfaces that are not specular; what is deeper is black. Glass
// reflects or refracts by chance, so a chain is one ray; its numbers depend on pixel, sample and
// depth alone.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>

#include "slave/core/integrate/scattered_rays.h"

namespace tessera::core {

// 16: in and out of four glasses one behind another, each reflected once within. Of a white mirror
// room what is cut is dim only where mirrors are: 0.9^16 = 0.19.
inline constexpr int kSpecularDepthMax = 16;

class SpecularChain {
 public:
  struct Memory {
    ScatteredRays::Memory rays;
    int order[kBatchMax];            // of rays: those of one group are neighbours
    std::uint64_t group[kBatchMax];  // by ray: what it is traced together with
    bool is_gone[kBatchMax];         // by surface: nothing more comes from there
  };

  // Requires: both outlive it. `is_seen`: chains begin at what the camera sees.
  SpecularChain(const RenderContext& context, Memory& memory, bool is_seen = true)
      : context_(context), memory_(memory), is_seen_(is_seen), rays_(context, memory.rays) {}

  // Surfaces that are left keep their order, pixel and key. Requires: batch.key is set. Returns:
  // rays traced.
  std::uint64_t follow(SurfaceBatch& batch, Vec3f* radiance);

 private:
  int scatter(const SurfaceBatch& batch, std::uint32_t depth);
  void trace_packet(SurfaceBatch& batch, const int* rays, int n, Vec3f* radiance);

  const RenderContext& context_;
  Memory& memory_;
  const bool is_seen_;
  ScatteredRays rays_;
};

}  // namespace tessera::core
