// SPDX-License-Identifier: Apache-2.0
// The box of a scene with instances, equal to that of the same scene flattened. Boxes of instances
// are wider than their corners, and what is chosen by the size of a scene must not depend on how it
// is stored.
//
// Threads. Pure functions.
#pragma once

#include "common/math/bounds3.h"
#include "slave/core/primitive/instance/mesh_index.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// `flattened`: the box of the triangles that are flattened, or empty. Returns: the least box that
// holds them and every corner, in world space as float32 arithmetic has it, of instances' triangles
// that have an area there.
template <int W>
Bounds3f exact_bounds(const InstancedBvh<W>& index, const Bounds3f& flattened);

}  // namespace tessera::core
