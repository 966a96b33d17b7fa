// SPDX-License-Identifier: Apache-2.0
// Samples of lights for the surfaces of a batch, one for each surface: where the light comes from,
// and what an unoccluded surface sends to its pixel of it.
//
// Samples, lights and glossy BSDFs are computed a packet at a time by the kernels.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>

#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/integrate/render_context.h"
#include "slave/core/scene/surface_batch.h"

namespace tessera::core {

class LightSamples {
  // A light sample.
  struct Arriving {
    Vec3f to_light, light;  // unit; radiance, or intensity
    float strength;         // factor of the light that an unoccluded surface gets
    float pdf;              // by solid angle; 0 where no BSDF sample can find the light
  };
  // Surfaces of one slot that wait for their BSDFs.
  struct Waiting {
    BsdfPacket packet;
    int surface[BsdfPacket::kMax];
  };

 public:
  // Arrays are indexed by surface of the batch, except the scratch memory of one packet.
  struct Memory {
    bool is_active[kBatchMax];
    Vec3f start[kBatchMax], direction[kBatchMax], contribution[kBatchMax];
    Arriving arriving[kBatchMax];
    LitSurfaces lit[kBatchMax / kLitPoints];
    // Scratch memory of one packet of surfaces.
    SkyPoints sky{};
    SamplePoints samples{};
    EmitterSamples emitters{};
    const Emitter* emitter[kLitPoints];            // by sample
    float on_patch[2][kLitPoints];                 // u, v of samples of patches
    BsdfPacket sky_directions;                     // samples of an even sky
    std::unique_ptr<Waiting> waiting[kBsdfSlots];  // made where surfaces need them

    Waiting& waiting_in(int slot) {
      if (waiting[slot] == nullptr) waiting[slot] = std::make_unique<Waiting>();
      return *waiting[slot];
    }
  };

  struct Options {
    int samples = 1;              // of each light, for each surface
    bool is_alone = true;         // diffuse surfaces send out no rays of their own that find lights
    bool picks_emitters = false;  // samples one of all emitters, by power
  };
  // Requires: context and memory outlive it.
  LightSamples(const RenderContext& context, Memory& memory, const Options& options);

  // Whether the light sample may add light to a surface. Where it does: the shadow ray, world
  // units, and what the surface's pixel gets if that ray is not blocked.
  bool is_active(int surface) const { return memory_.is_active[surface]; }
  Vec3f start(int surface) const { return memory_.start[surface]; }
  Vec3f direction(int surface) const { return memory_.direction[surface]; }
  Vec3f contribution(int surface) const { return memory_.contribution[surface]; }

  // Each of these samples a light for all surfaces of the batch, and replaces the samples before.

  // Samples a delta light. The ray to a directional one has no end; for others `start` is the
  // surface's point as it is, and the light is at t = 1.
  void of_light(const SurfaceBatch& batch, const Light& light);
  // Samples an emitter. Requires: hold(batch) was called. The emitter is at t = 1, just behind the
  // end of the shadow ray. `sample`: number of the pixels' sample.
  void of_emitter(const SurfaceBatch& batch, std::uint32_t emitter, std::uint32_t sample);
  void of_sky(const SurfaceBatch& batch, std::uint32_t sample);

  // Prepares for samples of emitters.
  void hold(const SurfaceBatch& batch);

 private:
  void clear(int count) { std::fill_n(memory_.is_active, count, false); }
  // Member by member: an Arriving put together elsewhere would be read again in wider pieces than
  // it was written in, and a load waits for such stores to leave the core.
  void put(int surface, Vec3f to_light, Vec3f light, float strength, float pdf) {
    Arriving& a = memory_.arriving[surface];
    a.to_light = to_light;
    a.light = light;
    a.strength = strength;
    a.pdf = pdf;
    memory_.is_active[surface] = strength > 0;
  }
  void draw(const SurfaceBatch& batch, int first, std::uint32_t dimension, std::uint32_t sample);
  void sample_emitters(const SurfaceBatch& batch, int first, std::uint32_t round,
                       std::uint32_t sample);
  void put_patch_points();
  void put_patch_places();  // where those points are on their patches
  void put_emitter(const Emitter& emitter, int i);
  void sample_even_sky(const SurfaceBatch& batch, std::uint32_t sample);
  void sample_map(const SurfaceBatch& batch, std::uint32_t sample);
  void respond(const SurfaceBatch& batch);
  void respond_in(int slot, const SurfaceBatch& batch);
  void settle(const SurfaceBatch& batch, int surface, Vec3f times_pi, float pdf);

  const RenderContext& context_;
  Memory& memory_;
  const Options options_;
  OpenSky sky_;
};

}  // namespace tessera::core
