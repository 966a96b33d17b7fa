// SPDX-License-Identifier: Apache-2.0
// Radiance and pdf of an environment map along one direction, in plain arithmetic.
// slave/core/light/sky-inl.h has to agree with them to the bit.
// Threads. Pure functions.
#pragma once

#include "slave/core/light/sky_map.h"

namespace tessera::test {

// `direction` need not be of unit length. A zero vector gets some texel's radiance.
Vec3f plain_radiance(const core::SkyMap& sky, Vec3f direction);
// Pdf, by solid angle, of sampling this direction. Requires: power() > 0, a unit vector.
float plain_pdf(const core::SkyMap& sky, Vec3f direction);

}  // namespace tessera::test
