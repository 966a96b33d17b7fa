// SPDX-License-Identifier: Apache-2.0
// Unbiased path tracing (path_tracer.h).
//
// Threads. One object per thread.
#pragma once

#include "slave/core/integrate/integrator.h"
#include "slave/core/integrate/lit_parts.h"
#include "slave/core/integrate/path/path_tracer.h"

namespace tessera::core {

class PathIntegrator final : public Integrator {
 public:
  RayCounts render(const RenderContext& context, const TileRect& rect,
                   std::span<float> rgb) override {
    PathTracer paths(context, paths_, context.settings.bounces);
    return LitParts(context, parts_).render(paths, rect, rgb);
  }

 private:
  LitParts::Memory parts_;
  PathTracer::Memory paths_;
};

}  // namespace tessera::core
