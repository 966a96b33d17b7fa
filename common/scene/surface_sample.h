// SPDX-License-Identifier: Apache-2.0
// Some of a surface's patches, drawn from its block without regard to their order: from what these
// take when they are prepared follows what all of them take.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/scene/patch_surface.h"

namespace tessera {

struct SurfaceSample {
  PatchSurface surface;           // of the patches that were drawn, with their loops; one material
  std::uint64_t patch_count = 0;  // of the whole surface
};

// Returns: how many patches a surface has; 0 for bytes that are none.
std::uint64_t patches_of_surface(std::span<const std::byte> block);

// A number that surfaces share whose patches have the same forms and trims, wherever their control
// points are, as those of one that deforms have; others seldom do. Returns: 0 for bytes that are no
// surface.
std::uint64_t form_of_surface(std::span<const std::byte> block);

// Draws about `wanted` patches, all where there are no more; the same ones every time.
// Returns: nothing for bytes that are no valid surface, or whose sample is not.
std::optional<SurfaceSample> sample_surface(std::span<const std::byte> block, std::uint64_t wanted);

}  // namespace tessera
