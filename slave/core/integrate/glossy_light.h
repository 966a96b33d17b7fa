// SPDX-License-Identifier: Apache-2.0
// Light of lamps and sky that glossy surfaces find with rays sampled from their BSDF: the share
// that MIS leaves beside light samples (direct_light.h), since light samples seldom find a sharp
// highlight. It is a part of direct light; in longer paths the next ray of the path does the same.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>

#include "slave/core/integrate/scattered_rays.h"

namespace tessera::core {

class GlossyLight {
 public:
  // Requires: both outlive it; light samples are as many as the settings say.
  GlossyLight(const RenderContext& context, ScatteredRays::Memory& memory)
      : context_(context), rays_(context, memory) {}

  // Adds that light to radiance [pixel]; surfaces that do not scatter in lobes are passed over.
  // Returns: rays traced.
  std::uint64_t add(const SurfaceBatch& batch, Vec3f* radiance);

 private:
  void trace(Vec3f* radiance);

  const RenderContext& context_;
  ScatteredRays rays_;
};

}  // namespace tessera::core
