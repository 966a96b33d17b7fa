// What sheds light in one scene version: lights without extent, and triangles that emit.
//
// Threads. Filled once, then read by any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/geometry/triangle_store.h"

namespace tessera::core {

// Up to this many emitting triangles each get all light samples of a pixel; above it the samples
// are shared out by power, so that cost does not grow with the number of emitters.
inline constexpr std::size_t kEmittersEachMax = 64;

// Also for NaN: no light.
inline bool is_black(Vec3f c) { return !(c.x > 0 || c.y > 0 || c.z > 0); }

struct Emitter {
  Vec3f a, edge_b, edge_c;  // A, B - A, C - A, world units
  Vec3f normal;             // unit, along (B - A) x (C - A): the side that emits
  Vec3f emission;           // radiance
  float area = 0;           // greater than 0
  float share = 1;          // chance to be picked, by power
};

struct LightSet {
  std::vector<Light> lights;  // direction normalised
  std::vector<Emitter> emitters;
  std::vector<float> cumulative;  // [emitter_count], of the shares; ends at 1
  Vec3f environment;              // radiance
  double power = 0;               // luminance times area of all emitters
  bool has_environment = false;

  bool is_empty() const { return lights.empty() && emitters.empty() && !has_environment; }
  bool is_shared_out() const { return emitters.size() > kEmittersEachMax; }
  // Requires: there are emitters; 0 <= x < 1.
  // rest: what of x is still free, in [0, 1): for a place on the emitter, since another dimension
  // of the same sample need not be independent of x. May be x itself.
  const Emitter& pick(float x, float& rest) const;
  // By area, with which one sample finds a point of an emitter: of one that pick() has chosen, or of
  // this one by itself.
  float density_by_area(Vec3f emission, float area, bool is_picked) const;
};

// left_out: numbers of triangles that stayed out of the tree, rising; they do not emit.
LightSet make_light_set(const Scene& scene, const TriangleStore& triangles,
                        std::span<const std::uint64_t> left_out);

}  // namespace tessera::core
