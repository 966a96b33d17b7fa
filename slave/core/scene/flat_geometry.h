// SPDX-License-Identifier: Apache-2.0
// The triangles of a scene that has no instances, all of them flattened, with their structure. In a
// version of a scene in which only corners have moved, the structure of the version before is
// fitted to them; it is built again when rays in it have become too dear. What takes the place of
// another version is built fast (bvh_fast_builder.h).
//
// Threads. Plain functions; the calling thread and up to thread_count - 1 more work.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/scene/geometry.h"

namespace tessera::core {

// A fitted structure is kept while rays in it cost at most this much of what they cost when it was
// built, by sah_cost(). A slave may lose 0.15 of the speed of its rays to what is not built anew:
// their time may grow by 1 / (1 - 0.15). Times grow by less than the estimate does, since part of a
// ray's time is no traversal.
inline constexpr double kFittedCostMax = 1 / 0.85;

// Fills in triangles, left_out, index and what was built. `other`: another version of the scene, or
// null. Requires: meshes, instances, structure and instancing of the geometry are set. Returns:
// kCancelled; kResourceExhausted.
template <int W>
Status build_flat_geometry(const Geometry* other, const BuildControl& control, Geometry& geometry);

// Notes the numbers of triangles whose box is empty. Shape: numbers [triangle], or empty where a
// triangle's number is its place.
void leave_out(const std::vector<Bounds3f>& boxes, std::span<const std::uint32_t> numbers,
               Geometry& geometry);

}  // namespace tessera::core
