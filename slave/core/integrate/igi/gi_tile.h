// SPDX-License-Identifier: Apache-2.0
// A tile lit by VPLs: instant global illumination (Benthin, thesis, chapter 9), breadth first.
//
// Blocks of 64x64 pixels, one sample of all their pixels at a time: camera rays in packets, then for
// each of the K^2 interleaved sets of VPLs the shadow rays of its pixels, VPL by VPL, then the
// discontinuity buffer, which multiplies by the surfaces' own colours. Blocks have a border as wide
// as the filter reaches, rendered here and not fetched, so that only pixels travel (section 9.5).
// What a pixel gets depends on (settings, scene, isa, pixel, sample) alone: patterns stand still on
// the picture, and the border's pixels are the neighbours' own, to the bit.
//
// Behind mirrors and glass it is the surface at the end of the chain that gathers. Glossy surfaces do
// not: few VPLs would be as many highlights; they are path-traced (path_tracer.h).
//
// With several samples per pixel each takes its share of the set (section 9.4): number i of a set
// goes to sample i modulo their number.
//
// Threads. One object per thread; scratch memory, some megabytes, taken at the first tile.
#pragma once

#include <atomic>
#include <memory>
#include <span>

#include "common/frame/frame_stats.h"
#include "common/frame/tile_grid.h"
#include "slave/core/camera/camera_rays.h"
#include "slave/core/integrate/igi/vpl_set.h"

namespace tessera::core {

// Passes behind these are not filtered: neighbours calm a picture of few passes, and the mean of many
// is calm by itself and keeps the truth of each pixel.
inline constexpr std::uint32_t kFilteredPasses = 16;

class GiTile {
 public:
  GiTile();
  ~GiTile();

  // As TileRenderer::render().
  RayCounts render(const PreparedScene::Impl& scene, const SceneTracer& tracer,
                   const FrameSettings& settings, const VplSets& vpls, const CameraRays& camera,
                   const TileRect& tile, std::span<float> rgb,
                   const std::atomic<bool>* is_cancelled);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace tessera::core
