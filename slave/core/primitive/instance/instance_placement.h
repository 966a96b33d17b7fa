// SPDX-License-Identifier: Apache-2.0
// The placement of an instance: what the kernels have to know of its transform, and the bounds of
// rounding that they rely on.
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "common/math/bounds3.h"
#include "common/math/transform.h"
#include "slave/core/primitive/instance_layout.h"

namespace tessera::core {

// Returns: nothing where the transform has no inverse that float32 can hold, or sends the mesh out
// of float32; such an instance is to be flattened. bounds: of the mesh's corners, object space.
// `mesh` and `first_primitive` are the caller's to fill.
std::optional<InstanceBlock> place_instance(const Transform& to_world, const Bounds3f& bounds);

// Returns: by axis of the world, how far a corner in the box may be rounded away from where the map
// brings it. Requires: as placed_bounds().
std::array<double, 3> corner_roundings(const Transform& to_world, const Bounds3f& corners);

// Returns: a box that holds every corner that float32 arithmetic makes of a corner in `parts`,
// boxes in object space. Requires: place_instance() took the transform.
Bounds3f placed_bounds(const Transform& to_world, std::span<const Bounds3f> parts);

}  // namespace tessera::core
