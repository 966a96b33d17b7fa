// SPDX-License-Identifier: Apache-2.0
// The lights of one scene version: delta lights, triangles and sub-patches that emit, and the
// environment.
//
// Threads. Filled once, then read by any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/light/emitter.h"
#include "slave/core/light/feature.h"
#include "slave/core/light/sky_map.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/surface/texture.h"

namespace tessera::core {

// Up to this many emitting triangles each get all light samples of a pixel; above it the samples
// are shared out by power, so that cost does not grow with the number of emitters.
inline constexpr std::size_t kEmittersEachMax = 64;

struct LightSet {
  std::vector<Light> lights;      // direction normalised
  std::vector<Emitter> emitters;  // by rising triangle; two for one that emits to both sides
  std::vector<EmitterTexture> emitter_textures;
  std::vector<float> cumulative;          // [emitter_count], of the shares; ends at 1
  Vec3f environment;                      // radiance, or what multiplies the map's
  std::shared_ptr<const SkyMap> sky_map;  // null: the same light from everywhere
  Feature has_environment{};
  // Whether surfaces emit that are opaque in parts only; they have no emitters.
  bool has_partial_emission = false;
  Background background;
  std::shared_ptr<const PatchStore> patches;  // of emitters; null where the scene has none

  bool is_empty() const { return lights.empty() && emitters.empty() && !has_environment; }
  // Whether camera rays that hit nothing see any light.
  bool is_background_lit() const {
    return background.kind == BackgroundKind::kGradient || has_environment;
  }
  bool is_shared_out() const { return emitters.size() > kEmittersEachMax; }
  // Picks an emitter by power. Requires: there are emitters; 0 <= x < 1.
  // rest: becomes what of x is still free, in [0, 1). It serves for a place on the emitter, since
  // another dimension of the same sample need not be independent of x. May be x itself.
  const Emitter& pick(float x, float& rest) const;
  // Radiance at point A + u (B - A) + v (C - A) of an emitter.
  Vec3f emission_at(const Emitter& emitter, float u, float v) const;
  // One over the pdf by area with which that point of an emitter is sampled.
  float area_at(const Emitter& emitter, float u, float v) const;
  // Returns: null where the light of a primitive is left to rays that hit it.
  const Emitter* emitter_of(std::uint32_t triangle) const;
};

// left_out: numbers of triangles that stayed out of the tree, rising; they do not emit.
// textures: of the scene, by index.
// other: the light set of another version of the scene, whose sky map is shared if its picture is
// the same; may be null.
LightSet make_light_set(const Scene& scene, const TriangleStore& triangles,
                        std::shared_ptr<const PatchStore> patches,
                        std::span<const std::uint64_t> left_out,
                        std::span<const std::shared_ptr<const MipMap>> textures,
                        const LightSet* other);

}  // namespace tessera::core
