// SPDX-License-Identifier: Apache-2.0
// Samples of lights for the surfaces of a batch, one for each: where they come from, and what the
// surfaces send to their pixels of them, if nothing is in the way.
//
// Samples, lights and glossy BSDFs are computed a packet at a time by the kernels.
//
// Threads. One object per thread; scratch memory.
#pragma once

#include <algorithm>
#include <cstdint>

#include "slave/core/integrate/bsdf_packet.h"
#include "slave/core/integrate/open_sky.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/surface_batch.h"

namespace tessera::core {

class LightSamples {
 public:
  bool is_active[kBatchMax];  // by surface of the batch: there is light to be had
  // Where there is: a ray that tells whether anything is in the way, world units, and what the surface's
  // pixel gets if nothing is.
  Vec3f start[kBatchMax], direction[kBatchMax];
  Vec3f contribution[kBatchMax];

  struct Options {
    int samples = 1;              // of each light, for each surface
    bool is_alone = true;         // diffuse surfaces send out no rays of their own that find lights
    bool picks_emitters = false;  // one of all, by power
  };
  // Keeps references until the next call. Requires: both outlive the calls of the others.
  void begin(const PreparedScene::Impl& scene, const KernelTable& kernels, const Options& options);

  // Each: for all surfaces of the batch, which replace those before.

  // Of a delta light. A directional one's ray has no end; of others `start` is the surface's
  // point as it is, and the light is at 1.
  void of_light(const SurfaceBatch& batch, const Light& light);
  // Requires: hold(batch) was called. The ray ends just before the emitter at 1. `sample`: number of the
  // pixels' sample.
  void of_emitter(const SurfaceBatch& batch, std::uint32_t emitter, std::uint32_t sample);
  void of_sky(const SurfaceBatch& batch, std::uint32_t sample);

  // Prepares for samples of emitters.
  void hold(const SurfaceBatch& batch);

 private:
  // A light sample.
  struct Arriving {
    Vec3f to_light, light;  // unit; radiance, or intensity
    float strength;         // of which the surface gets so much, if nothing is in the way
    float pdf;              // by solid angle; 0 where no ray of the BSDF's own can find it
  };

  void clear(int count) { std::fill_n(is_active, count, false); }
  void put(int surface, const Arriving& from) {
    arriving_[surface] = from;
    is_active[surface] = from.strength > 0;
  }
  void draw(const SurfaceBatch& batch, int first, std::uint32_t dimension, std::uint32_t sample);
  void sample_emitters(const SurfaceBatch& batch, int first, std::uint32_t round,
                       std::uint32_t sample);
  void put_emitter(const Emitter& emitter, int i);
  void sample_even_sky(const SurfaceBatch& batch, std::uint32_t sample);
  void sample_map(const SurfaceBatch& batch, std::uint32_t sample);
  void respond(const SurfaceBatch& batch);

  const PreparedScene::Impl* scene_ = nullptr;
  const KernelTable* kernels_ = nullptr;
  Options options_;
  Arriving arriving_[kBatchMax];
  OpenSky sky_;
  SamplePoints samples_{};
  LitSurfaces lit_[kBatchMax / kLitPoints];
  EmitterSamples emitters_{};
  const Emitter* emitter_[kLitPoints];  // of them
  // Surfaces of one kind that wait for their BSDFs.
  struct Waiting {
    BsdfPacket packet;
    int surface[BsdfPacket::kMax];
  };
  Waiting glossy_, layered_;
};

}  // namespace tessera::core
