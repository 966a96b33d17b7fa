// SPDX-License-Identifier: Apache-2.0
// Rays that leave surfaces as their BSDFs scatter light, and the surfaces that they meet: the part
// that paths, chains of mirrors and reflections of lamps have in common.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>

#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/render_context.h"
#include "slave/core/scene/met_surfaces.h"
#include "slave/core/scene/surface_batch.h"

namespace tessera::core {

class ScatteredRays {
 public:
  struct Asked {
    int surface;
    std::uint32_t key;
  };
  struct Memory {
    Vec3f start[kBatchMax], direction[kBatchMax];  // unit
    Vec3f weight[kBatchMax];                       // of what the ray meets, in the pixel
    // By solid angle, where light samples took their share of what is met; 0 where they took none
    // (after mirror and glass).
    float pdf[kBatchMax];
    RayCone cone[kBatchMax];
    int origin[kBatchMax];  // the surface's index in its batch
    std::uint16_t pixel[kBatchMax];
    std::uint32_t key[kBatchMax];

    Asked asked[kBatchMax];
    SamplePoints samples{};
    BsdfPackets bsdfs;
    RayPacket packet;
    PacketHits hits;
    int number[kPacketRays];     // of the packet's rays
    RayCone cones[kPacketRays];  // of them, where the scene needs cones
    MetSurfaces::Memory met;
    SkyPoints sky{};
  };

  // Requires: both outlive it.
  ScatteredRays(const RenderContext& context, Memory& memory);

  // Before the first ray of a batch.
  void clear();
  // Asks for a ray of surface i. Requires: at most kBatchMax in all.
  void ask(int i, std::uint32_t ray_key) { memory_.asked[asked_count_++] = {i, ray_key}; }
  // Makes the rays that were asked for, in their order, but for those that nothing can come from: by the
  // sample of that number in this dimension of their keys (shuffled_2d()).
  void scatter(const SurfaceBatch& batch, std::uint32_t dimension, std::uint32_t sample);

  int count() const { return count_; }
  // Of a ray, from 0:
  Vec3f direction(int ray) const { return memory_.direction[ray]; }
  Vec3f weight(int ray) const { return memory_.weight[ray]; }
  float pdf(int ray) const { return memory_.pdf[ray]; }
  int origin(int ray) const { return memory_.origin[ray]; }
  std::uint16_t pixel(int ray) const { return memory_.pixel[ray]; }
  std::uint32_t key(int ray) const { return memory_.key[ray]; }

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
  void look_at_sky(std::uint64_t open) { sky_.look(memory_.packet.direction, open); }
  // What the packet's ray `i` brings from there, after that look: with the same shares, or as a whole
  // where its surface was specular.
  Vec3f sky_met(int i) const;

 private:
  struct Scattered {
    Vec3f direction, weight;
    float pdf, widening;  // of the cone
    bool is_through = false;
  };

  // By the samples in the memory.
  void scatter_some(const SurfaceBatch& batch, const Asked* asked, int n);
  void push(const SurfaceBatch& batch, const Asked& asked, const Scattered& out);

  const RenderContext& context_;
  Memory& memory_;
  int count_ = 0, asked_count_ = 0;
  MetSurfaces met_;
  OpenSky sky_;
};

}  // namespace tessera::core
