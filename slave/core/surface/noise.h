// Gradient noise over space: smooth, in [-1, 1], 0 at the corners of the unit lattice, without a
// preferred axis (Perlin, "Improving noise", 2002: quintic fade, gradients along the edges of a
// cube). Gradients come from an integer hash instead of a table, so that it has no period.
//
// The same bits on every processor and C library: arithmetic and floor only.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>

#include "common/math/vec3.h"

namespace tessera::core {

// 0 beyond 2^22 units from the origin, where floats have no fraction left to speak of, and for NaN.
float gradient_noise(Vec3f p, std::uint32_t seed);

// Sum of |noise| of up to 6 octaves, amplitudes 1, 1/2, ...: Perlin's turbulence, in [0, 2].
// Octaves finer than `footprint` (in the units of p) fade into their mean, so that what is far away
// does not flicker.
float turbulence(Vec3f p, std::uint32_t seed, float footprint);

}  // namespace tessera::core
