// SPDX-License-Identifier: Apache-2.0
// The virtual point lights (VPLs) of one frame: what its pixels gather light from.
//
// Random walks from all lights leave a VPL on each surface that they meet (Keller, "Instant
// radiosity", 1997; Benthin, thesis, chapter 9). For K x K interleaving there are K^2 sets, each an
// unbiased estimate of all light by itself, so that a pixel may gather from any of them. A set
// divides its VPLs among the light of 0, 1, 2... surfaces before the last by the power that each of
// these carries in a few pilot walks, at least one VPL each. Of n walks, the first n_d leave a VPL
// on their surface number d, with 1 / n_d of the light.
//
// A VPL sheds light as a diffuse surface of the same albedo would, also where the surface is
// glossy. Mirrors and glass pass light on, and count as a surface. The light that they throw onto
// diffuse surfaces (caustics) is carried on from there by VPLs, but is not seen there itself.
//
// All VPLs follow from scene, settings and instruction set, so that every slave makes the same.
//
// Threads. Made by one, then read by any.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/frame_settings.h"
#include "slave/core/light/light_subpaths.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

class VplSets {
 public:
  // Requires: valid settings.
  VplSets(const PreparedScene::Impl& scene, const SceneTracer& tracer,
          const FrameSettings& settings);

  // VPLs of set k, 0 <= k < interleave^2, those of few surfaces first. They are split over the
  // samples of a pixel as they stand: VPL number i goes to sample i modulo the number of samples.
  std::span<const LightPoint> set(int k) const { return sets_[static_cast<std::size_t>(k)]; }
  // Delta lights, where they are few, as VPLs that all pixels and samples gather from.
  std::span<const LightPoint> each() const { return each_; }
  // Rays that were traced to make the VPLs.
  std::uint64_t ray_count() const { return ray_count_; }

 private:
  class Walks;
  class WalkedPoints;

  // Luminous power that light of each depth carries, found by a few walks. Shape: [bounces + 1].
  std::vector<double> power_by_depth(Walks& walks, const LightSubpaths& light, std::size_t depths);
  void make_sets(Walks& walks, const LightSubpaths& light, std::uint32_t key,
                 const std::vector<int>& counts);

  std::vector<std::vector<LightPoint>> sets_;
  std::vector<LightPoint> each_;
  std::uint64_t ray_count_ = 0;
};

}  // namespace tessera::core
