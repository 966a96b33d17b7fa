// SPDX-License-Identifier: Apache-2.0
// Gradient noise over space: smooth, in [-1, 1], 0 at the corners of the unit lattice, without a
// preferred axis (Perlin, "Improving noise", 2002: quintic fade, gradients along the edges of a
// cube). Gradients come from an integer hash instead of a table, so that the noise has no period.
// It is 0 beyond 2^22 units from the origin, where floats have no fraction left to speak of, and
// for NaN.
//
// Many points at a time, and all octaves of them, fill the registers of
// slave/core/surface/noise-inl.h. Results are the same to the bit on every processor and C library,
// since only arithmetic and floor are used.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "slave/core/surface/noise_layout.h"

namespace tessera::core {

// Coordinates of points; all of one length, at most kNoisePoints.
struct NoiseArgument {
  std::span<const float> x, y, z;
};

class Noise {
 public:
  explicit Noise(NoiseKernel kernel) : kernel_(kernel) {}

  // Shape of noise: [points].
  void gradient(const NoiseArgument& points, std::uint32_t seed, std::span<float> noise) const;

  // Sum of |noise| of up to 6 octaves, amplitudes 1, 1/2, ...: Perlin's turbulence, in [0, 2].
  // Octaves finer than `footprint` [points] (in the units of the points) fade into their mean, so
  // that what is far away does not flicker.
  void turbulence(const NoiseArgument& points, std::uint32_t seed, std::span<const float> footprint,
                  std::span<float> sum) const;

 private:
  NoiseKernel kernel_;
};

}  // namespace tessera::core
