// SPDX-License-Identifier: Apache-2.0
// The distance that each camera ray goes, as grey: nothing is lit.
//
// Threads. One object per thread.
#pragma once

#include "slave/core/integrate/integrator.h"
#include "slave/core/integrate/tile_parts.h"

namespace tessera::core {

class PrimaryIntegrator final : public Integrator {
 public:
  RayCounts render(const RenderContext& context, const TileRect& rect,
                   std::span<float> rgb) override;

 private:
  PacketHits hits_;
  PartPixels pixels_;
};

}  // namespace tessera::core
