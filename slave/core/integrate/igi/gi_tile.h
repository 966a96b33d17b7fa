// SPDX-License-Identifier: Apache-2.0
// A tile lit by VPLs: instant global illumination (Benthin, thesis, chapter 9), breadth first.
//
// A tile is rendered in blocks of 64x64 pixels, one sample of all pixels of a block at a time.
// Camera rays are traced in packets; then, for each of the K^2 interleaved sets of VPLs, the shadow
// rays of its pixels, VPL by VPL. Last comes the discontinuity buffer, which multiplies by the
// surfaces' albedo. Blocks have a border as wide as the filter reaches, rendered here and not
// fetched, so that only pixels travel (section 9.5). What a pixel gets depends on (settings, scene,
// isa, pixel, sample) alone: patterns stand still on the picture, and the border's pixels are the
// neighbours' own, to the bit.
//
// Behind mirrors and glass it is the surface at the end of the chain that gathers. Glossy surfaces
// do not gather, since each of a few VPLs would show as a highlight; they are path-traced
// (path_tracer.h).
//
// With several samples per pixel each takes its share of the set (section 9.4): number i of a set
// goes to sample i modulo their number.
//
// Threads. One object per thread; memory of some megabytes, taken at the first tile.
#pragma once

#include <cstdint>
#include <memory>

#include "slave/core/integrate/integrator.h"

namespace tessera::core {

class GiTile final : public Integrator {
 public:
  GiTile();
  ~GiTile() override;

  RayCounts render(const RenderContext& context, const TileRect& tile,
                   std::span<float> rgb) override;

 private:
  class Work;
  struct Memory;
  std::unique_ptr<Memory> memory_;
  std::unique_ptr<Integrator> in_the_dark_;  // renders scenes without any light
};

}  // namespace tessera::core
