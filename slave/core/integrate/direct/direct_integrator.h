// SPDX-License-Identifier: Apache-2.0
// Light that surfaces get straight from lamps and sky (direct_light.h).
//
// Threads. One object per thread.
#pragma once

#include "slave/core/integrate/direct_light.h"
#include "slave/core/integrate/integrator.h"
#include "slave/core/integrate/lit_parts.h"

namespace tessera::core {

class DirectIntegrator final : public Integrator {
 public:
  RayCounts render(const RenderContext& context, const TileRect& rect,
                   std::span<float> rgb) override;

 private:
  LitParts::Memory parts_;
  DirectLight::Memory light_;
};

}  // namespace tessera::core
