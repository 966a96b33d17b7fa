// SPDX-License-Identifier: Apache-2.0
// Radiance of the sky along rays that have met nothing, and samples of the sky, a packet at a time.
//
// Threads. One object per thread, over memory of its own.
#pragma once

#include <cstdint>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/light/light_set.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {

class OpenSky {
 public:
  // Requires: all outlive it.
  OpenSky(const LightSet& lights, const KernelTable& kernels, SkyPoints& memory);

  // Whether the sky is an environment map. An even sky has a radiance alone, so that no direction
  // is better to sample than another.
  bool has_map() const { return lights_.sky_map != nullptr; }

  // Looks up the sky along direction [axis][ray] for each of `rays`.
  void look(const float (&direction)[3][kPacketRays], std::uint64_t rays);
  // Radiance along a ray, found by the last look().
  Vec3f radiance(int ray) const {
    return has_map() ? lights_.environment * vector_at(memory_.radiance, ray) : lights_.environment;
  }
  // look_out() and background() do the same for camera rays, which see the scene's background.
  void look_out(const float (&direction)[3][kPacketRays], std::uint64_t rays);
  Vec3f background(int ray) const {
    return lights_.background.kind == BackgroundKind::kSky ? radiance(ray)
                                                           : vector_at(memory_.radiance, ray);
  }
  float pdf(int ray) const { return memory_.pdf[ray]; }

  // Samples the map at these points. Requires: has_map(); points.count > 0.
  void sample(const SamplePoints& points);
  // Sample of point i, without the factor LightSet::environment.
  SkyMap::Sample drawn(int i) const {
    return {vector_at(memory_.direction, i), vector_at(memory_.radiance, i), memory_.angle[i]};
  }

 private:
  const LightSet& lights_;
  const KernelTable& kernels_;
  const SkyView view_;
  SkyPoints& memory_;
};

}  // namespace tessera::core
