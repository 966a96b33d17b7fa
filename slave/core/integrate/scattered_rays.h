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
#include "slave/core/ray/ray_list.h"
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
    RayList rays;             // directions are unit vectors
    ListHits found;           // of the list that was traced last
    Vec3f weight[kBatchMax];  // throughput of what the ray meets, to the pixel
    // Pdf of the direction by solid angle, for the MIS weight of what the ray meets; 0 after a
    // mirror or glass, where light samples have no share.
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
    int number[kPacketRays];     // of the packet's rays, as in the arrays above
    RayCone cones[kPacketRays];  // of the packet's rays, where the scene needs cones
    MetSurfaces::Memory met;
    SkyPoints sky{};
  };

  // Requires: both outlive it.
  ScatteredRays(const RenderContext& context, Memory& memory);

  // Must be called before the first ray of a batch.
  void clear();
  // Asks for a ray of surface i. Requires: at most kBatchMax in all.
  void ask(int i, std::uint32_t ray_key) { memory_.asked[asked_count_++] = {i, ray_key}; }
  // Makes the rays that were asked for, in their order, except those that cannot bring any light.
  // Each ray is sampled by number `sample` of its key's sequence in this dimension (shuffled_2d()).
  void scatter(const SurfaceBatch& batch, std::uint32_t dimension, std::uint32_t sample);

  int count() const { return count_; }
  // `ray`: number of the ray, from 0.
  Vec3f direction(int ray) const { return memory_.rays.direction(ray); }
  Vec3f weight(int ray) const { return memory_.weight[ray]; }
  float pdf(int ray) const { return memory_.pdf[ray]; }
  int origin(int ray) const { return memory_.origin[ray]; }
  std::uint16_t pixel(int ray) const { return memory_.pixel[ray]; }
  std::uint32_t key(int ray) const { return memory_.key[ray]; }

  // Traces all rays.
  void trace_all() { trace(memory_.rays); }
  // Takes n rays from number `first` on as the packet at hand. Requires: trace_all() was called;
  // first is a multiple of kPacketRays, and n is at most that. Returns: bits of the packet's rays
  // that have met something.
  std::uint64_t take(int first, int n);

  // For who has an order of its own: puts the n rays of these numbers in a packet of a list, which
  // has no rays yet. Requires: n <= kPacketRays.
  void put(const int* numbers, int n, RayList& list, int packet) const;
  void trace(const RayList& list) { context_.tracer.closest(list.many(), memory_.found.arrays()); }
  // Takes a packet of the list that was traced last as the packet at hand. numbers: of its rays.
  // Returns: as take() above.
  std::uint64_t take(const RayList& list, int packet, const int* numbers);

  // The functions below are about the packet at hand.

  // Makes *to[i], the surface that the packet's ray i has met, for each bit i of `met`. `batch`:
  // see MetSurfaces.
  void meet(std::uint64_t met, Surface* const* to, SurfaceBatch* batch, bool is_seen = false);
  // Light that the packet's ray `i` brings from the emitter `s` that it has met, times its MIS
  // weight (balance heuristic) against as many light samples of the same surface. An emission
  // texture is looked up without mip levels, as light samples do. `is_picked`: light samples pick
  // one of all emitters.
  Vec3f emission_met(int i, const Surface& s, bool is_picked) const;

  // Looks up the sky for the rays of the packet that have met nothing.
  void look_at_sky(std::uint64_t open) { sky_.look(memory_.packet.direction, open); }
  // Light that the packet's ray `i` brings from the sky after look_at_sky(), times its MIS weight.
  // The weight is 1 under an even sky, or where the ray's surface was specular.
  Vec3f sky_met(int i) const;

 private:
  struct Scattered {
    Vec3f direction, weight;
    float pdf, widening;  // widening: of the cone
    bool is_through = false;
  };

  // Scatters n rays by the samples in the memory.
  void scatter_some(const SurfaceBatch& batch, const Asked* asked, int n);
  void push(const SurfaceBatch& batch, const Asked& asked, const Scattered& out);
  std::uint64_t find(const RayList& list, int packet);

  const RenderContext& context_;
  Memory& memory_;
  int count_ = 0, asked_count_ = 0;
  MetSurfaces met_;
  OpenSky sky_;
};

}  // namespace tessera::core
