// SPDX-License-Identifier: Apache-2.0
// Leaves out triangles that lie where many others do: no structure can part them, so that every ray
// that comes near would be tested with each, and a file of some megabytes would cost minutes.
//
// Two triangles are equal whose three corners are at the same places, in whatever order. Copies up
// to a bound stay as they are: sheets with two sides and decals have a few.
// Threads. Any.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"

namespace tessera::import {

inline constexpr std::uint32_t kEqualTrianglesMax = 16;

// Returns: how many were left out. The order of the others stays.
std::uint64_t leave_out_equal(Scene& scene);

}  // namespace tessera::import
