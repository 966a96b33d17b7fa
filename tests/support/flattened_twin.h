// SPDX-License-Identifier: Apache-2.0
// Compares a scene with instances to the same scene flattened, ray by ray and bit by bit.
// Threads. One.
#pragma once

#include <cstddef>
#include <random>
#include <vector>

#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/ray_caster.h"

namespace tessera::test {

// Returns: rays at corners, edges, faces and past them, which start outside, inside, near a surface
// or from one point.
std::vector<core::CastRay> rays_around(const core::TriangleStore& triangles, std::size_t count,
                                       std::mt19937& random);

// Casts the rays on every instruction set, alone and in packets, for the closest hit and for any;
// a difference fails the test. Returns: how many rays hit something.
std::size_t compare_with_flattened(const core::PreparedScene& flat,
                                   const core::PreparedScene& instanced,
                                   const std::vector<core::CastRay>& rays);

}  // namespace tessera::test
