// SPDX-License-Identifier: Apache-2.0
// The part of validate_scene() (validate.h) that is about freeform surfaces.
// Threads. Pure function.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/status.h"
#include "common/scene/patch_surface.h"

namespace tessera {

// Checks that the arrays fit each other, and every number in them. `name` opens the line.
// Returns: kInvalidArgument or kResourceExhausted naming patch, point, loop and segment by number.
Status validate_surface(const PatchSurface& surface, const std::string& name,
                        std::size_t material_count);

}  // namespace tessera
