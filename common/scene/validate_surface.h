// SPDX-License-Identifier: Apache-2.0
// The part of validate_scene() (validate.h) that is about freeform surfaces.
// Threads. Pure function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/base/status.h"
#include "common/scene/patch_surface.h"

namespace tessera {

// Most points and loops of one surface's trims, both together: pieces of segments name coefficients
// by 27 bits, and a loop has one coefficient more than points.
inline constexpr std::uint64_t kTrimPointsMax = (std::uint64_t{1} << 27) - 16;

// Checks that the arrays fit each other, and every number in them. `name` opens the line.
// Returns: kInvalidArgument or kResourceExhausted naming patch, point, loop and segment by number.
Status validate_surface(const PatchSurface& surface, const std::string& name,
                        std::size_t material_count);

}  // namespace tessera
