// SPDX-License-Identifier: Apache-2.0
// What is seen of a sky along one direction, in plain arithmetic: what slave/core/light/sky-inl.h has to
// agree with to the bit.
// Threads. Pure functions.
#pragma once

#include "slave/core/light/sky_map.h"

namespace tessera::test {

// `direction` need not be of unit length. Zero: some texel's.
Vec3f plain_radiance(const core::SkyMap& sky, Vec3f direction);
// By solid angle, with which samples take it. Requires: power() > 0, a unit vector.
float plain_pdf(const core::SkyMap& sky, Vec3f direction);

}  // namespace tessera::test
