// SPDX-License-Identifier: Apache-2.0
// The part of validate_scene() (validate.h) that is about triangle meshes.
// Threads. Pure function.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera {

// Checks that the arrays fit each other, and every number in them. `name` opens the line.
// Returns: kInvalidArgument or kResourceExhausted naming vertex or triangle by number.
Status validate_mesh(const Mesh& mesh, const std::string& name, std::size_t material_count);

}  // namespace tessera
