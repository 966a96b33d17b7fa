// Rays that leave surfaces as their BSDFs scatter light, and the surfaces that they meet: the part
// that paths, chains of mirrors and reflections of lamps have in common.
//
// Threads. One object per thread; scratch memory.
#pragma once

#include <cstdint>

#include "slave/core/bsdf/bsdf.h"
#include "slave/core/geometry/barycentric.h"
#include "slave/core/render/surface_batch.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

struct ScatteredRays {
  int count = 0;
  Vec3f start[kBatchMax], direction[kBatchMax];  // unit
  Vec3f weight[kBatchMax];                       // of what the ray meets, in the pixel
  // By solid angle, where light samples took their share of what is met; 0 where they took none
  // (after mirror and glass).
  float density[kBatchMax];
  RayCone cone[kBatchMax];
  int origin[kBatchMax];  // the surface's index in its batch
  std::uint16_t pixel[kBatchMax];
  std::uint32_t key[kBatchMax];

  // Before the first ray of a batch.
  void clear();
  // One ray of surface i, unless nothing can come from there. Requires: count < kBatchMax.
  void add(const SurfaceBatch& batch, int i, Vec2f square, std::uint32_t ray_key);

  // Replaces `surface` by what ray `i` has met. Returns: false when there is nothing.
  bool meet(const PreparedScene::Impl& scene, int i, std::uint32_t triangle, float t,
            Surface& surface) const;

  // What a surface's ray `i` brings from the emitter `s` that it has met: its share of it, where light
  // samples, as many and from the same surface, bring the rest (the balance heuristic). A lamp's
  // picture is looked at as they do, without mip levels. `is_picked`: they pick one of all emitters.
  Vec3f emission_met(const PreparedScene::Impl& scene, int i, std::uint32_t triangle, float t,
                     const Surface& s, bool is_picked) const;

  // What ray `i` brings from the sky when it has met nothing, with the same shares. Requires: its
  // surface was not specular.
  Vec3f sky_met(const LightSet& lights, int i) const;

  // The n rays of these numbers, as one packet. Requires: n <= kPacketRays.
  void trace(const SceneTracer& tracer, const int* rays, int n, PacketHits& hits);

 private:
  void add_sample(const SurfaceBatch& batch, int i, Vec2f square, std::uint32_t ray_key);
  int push(const SurfaceBatch& batch, int i, std::uint32_t ray_key);

  RayPacket packet_;
};

}  // namespace tessera::core
