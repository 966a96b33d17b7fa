// SPDX-License-Identifier: Apache-2.0
// Triangles and sub-patches that emit.
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <memory>

#include "common/math/vec3.h"
#include "slave/core/primitive/patch/patch_support.h"
#include "slave/core/surface/texture.h"

namespace tessera::core {

// A triangle; or a sub-patch, of which `a` and `normal` are the middle, edges are zero and the area
// is about its own (patch_emitter.h).
struct Emitter {
  Vec3f a, edge_b, edge_c;  // A, B - A, C - A, world units
  Vec3f normal;             // unit, along (B - A) x (C - A): the side that emits
  Vec3f emission;           // radiance; where a texture varies it, about its mean
  float area = 0;           // greater than 0
  float opacity = 1;        // chance that a ray meets the triangle; `emission` has it as a factor
  float share = 1;          // chance to be picked, by power
  std::uint32_t triangle = 0;  // its number as a primitive
  std::int64_t part = -1;      // its number in the patch store; of triangles -1
  bool is_back = false;        // of a sub-patch: the side against its normal emits
  std::int32_t texture = -1;   // index into LightSet::emitter_textures, or none

  bool is_patch() const { return kKnowsPatches && part >= 0; }
};

struct EmitterTexture {
  Vec2f uv_a, uv_b, uv_c;
  Vec3f emission;  // multiplied by the map's
  std::shared_ptr<const MipMap> map;
};

}  // namespace tessera::core
