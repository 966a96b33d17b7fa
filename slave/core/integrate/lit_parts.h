// SPDX-License-Identifier: Apache-2.0
// The surfaces that the camera rays of a part have met, gathered in a batch, and the light that
// reaches the pixels without any light sample: the background, the surfaces' own emission, and both
// of them behind mirrors and glass. How lights illuminate the batch is left to the renderer; see
// Shade.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <memory>
#include <optional>

#include "common/frame/frame_stats.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/specular_chain.h"
#include "slave/core/integrate/tile_parts.h"
#include "slave/core/scene/met_surfaces.h"

namespace tessera::core {

class LitParts {
 public:
  struct Memory {
    PacketHits hits;
    MetSurfaces::Memory met;
    SkyPoints sky{};
    SurfaceBatch batch;
    PartPixels pixels;
    std::unique_ptr<SpecularChain::Memory> chain;  // made where a scene has mirrors or glass
  };

  // Requires: both outlive it.
  LitParts(const RenderContext& context, Memory& memory);

  // Shade: has add(SurfaceBatch&, Vec3f* radiance) -> RayCounts, which adds what the surfaces of a
  // batch reflect. None of these surfaces is specular.
  template <class Shade>
  RayCounts render(Shade& shade, const TileRect& rect, std::span<float> rgb) {
    Batches<Shade> batches{*this, shade};
    counts_.primary += parts_.render(batches, memory_.hits, memory_.pixels, rect, rgb);
    return counts_;
  }

 private:
  template <class Shade>
  struct Batches {
    LitParts& of;
    Shade& shade;

    void begin_sample(std::uint32_t sample) const {
      SurfaceBatch& batch = of.memory_.batch;
      batch.count = 0;
      batch.sample_index = sequence_index(of.context_.settings, sample);
    }
    void packet(int x, int y) const { of.add_packet(x, y); }
    void end_sample() const {
      SurfaceBatch& batch = of.memory_.batch;
      if (batch.count == 0) return;
      if (of.context_.scene.features.has_specular) of.follow_chains();
      of.counts_ += shade.add(batch, of.memory_.pixels.radiance);
    }
  };

  void add_packet(int x, int y);
  void add_background(int x, int y);
  void add_surfaces(int x, int y);
  void follow_chains() {
    counts_.secondary += chain_->follow(memory_.batch, memory_.pixels.radiance);
  }

  const RenderContext& context_;
  Memory& memory_;
  TileParts parts_;
  MetSurfaces met_;
  OpenSky sky_;
  RayCone cones_[kPacketRays];  // of camera rays
  std::optional<SpecularChain> chain_;
  RayCounts counts_;
};

}  // namespace tessera::core
