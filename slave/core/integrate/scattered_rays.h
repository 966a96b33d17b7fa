// SPDX-License-Identifier: Apache-2.0
// Rays that leave surfaces as their BSDFs scatter light, and the surfaces that they meet: the part
// that paths, chains of mirrors and reflections of lamps have in common.
//
// Threads. One object per thread; scratch memory.
#pragma once

#include <cstdint>

#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/scene/met_surfaces.h"
#include "slave/core/scene/surface_batch.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

struct ScatteredRays {
  int count = 0;
  Vec3f start[kBatchMax], direction[kBatchMax];  // unit
  Vec3f weight[kBatchMax];                       // of what the ray meets, in the pixel
  // By solid angle, where light samples took their share of what is met; 0 where they took none
  // (after mirror and glass).
  float pdf[kBatchMax];
  RayCone cone[kBatchMax];
  int origin[kBatchMax];  // the surface's index in its batch
  std::uint16_t pixel[kBatchMax];
  std::uint32_t key[kBatchMax];

  // Keeps references until the next call. Requires: both outlive the calls of the others.
  void begin(const PreparedScene::Impl& scene, const SceneTracer& tracer);

  // Before the first ray of a batch.
  void clear();
  // Asks for a ray of surface i. Requires: at most kBatchMax in all.
  void ask(int i, std::uint32_t ray_key) { asked_[asked_count_++] = {i, ray_key}; }
  // Makes the rays that were asked for, in their order, but for those that nothing can come from: by the
  // sample of that number in this dimension of their keys (shuffled_2d()).
  void scatter(const SurfaceBatch& batch, std::uint32_t dimension, std::uint32_t sample);

  // The n rays of these numbers, as one packet. Requires: n <= kPacketRays. Returns: bits of those, in
  // the packet, that have met something.
  std::uint64_t trace(const int* rays, int n);

  // Of the packet that was traced last:

  // Makes *to[i] for each i of these bits, in the packet: what the ray has met.
  // `batch`: see MetSurfaces.
  void meet(std::uint64_t met, Surface* const* to, SurfaceBatch* batch, bool is_seen = false);
  // What the packet's ray `i` brings from the emitter `s` that it has met: its share of it, where light
  // samples, as many and from the same surface, bring the rest (the balance heuristic). A lamp's
  // picture is looked at as they do, without mip levels. `is_picked`: they pick one of all emitters.
  Vec3f emission_met(int i, const Surface& s, bool is_picked) const;

  // Looks at the sky for those of the packet that have met nothing.
  void look_at_sky(std::uint64_t open) { sky_.look(packet_.direction, open); }
  // What the packet's ray `i` brings from there, after that look: with the same shares, or as a whole
  // where its surface was specular.
  Vec3f sky_met(int i) const;

 private:
  struct Asked {
    int surface;
    std::uint32_t key;
  };
  struct Scattered {
    Vec3f direction, weight;
    float pdf, widening;  // of the cone
    bool is_through = false;
  };

  // By samples_.
  void scatter_some(const SurfaceBatch& batch, const Asked* asked, int n);
  void push(const SurfaceBatch& batch, const Asked& asked, const Scattered& out);

  const PreparedScene::Impl* scene_ = nullptr;
  const SceneTracer* tracer_ = nullptr;
  Asked asked_[kBatchMax];
  int asked_count_ = 0;
  SamplePoints samples_{};
  BsdfPacket diffuse_, glossy_, layered_;
  RayPacket packet_;
  PacketHits hits_;
  MetSurfaces met_;
  OpenSky sky_;
  int number_[kPacketRays];  // of the packet's rays
};

}  // namespace tessera::core
