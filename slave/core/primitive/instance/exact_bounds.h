// SPDX-License-Identifier: Apache-2.0
// The box of a scene with instances, equal to that of the same scene flattened. Boxes of instances
// are wider than their corners, and what is chosen by the size of a scene must not depend on how it
// is stored.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "common/math/bounds3.h"
#include "slave/core/primitive/instance/mesh_index.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// Sets `bounds` and `farthest` of the index: the least box that holds `flattened`, which may be
// empty, and every corner, in world space as float32 arithmetic has it, of instances' triangles
// that have an area there. `known`: another version with as many instances, of which `changed`,
// rising, are others, and which has the same triangles flattened; here they may be one more
// instance, the last. Or null.
template <int W>
void set_exact_bounds(const Bounds3f& flattened, const InstancedBvh<W>* known,
                      std::span<const std::uint32_t> changed, InstancedBvh<W>& index);

}  // namespace tessera::core
