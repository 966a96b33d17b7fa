// SPDX-License-Identifier: Apache-2.0
// What of lamps and sky glossy surfaces see by rays of their own BSDF: the share that light samples
// leave to them (direct_light.h), since a sharp highlight is seldom found from the lamp. Part of
// direct light; of longer paths the next ray does the same.
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

  // Adds to radiance [pixel]; surfaces that do not scatter in lobes are passed over. Returns: rays traced.
  std::uint64_t add(const SurfaceBatch& batch, Vec3f* radiance);

 private:
  void trace(Vec3f* radiance);

  const RenderContext& context_;
  ScatteredRays rays_;
};

}  // namespace tessera::core
