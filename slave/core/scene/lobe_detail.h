// SPDX-License-Identifier: Apache-2.0
// Optional lobes of a material at a point, from its textures, vertices and constants.
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/detail_layout.h"
#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// Lobes at point i of `points`, which were made for `group`. Requires: has_lobes(*s.material).
SurfaceLobes lobes_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i);

// The share of the surface at point i that passes light. Requires: passes_light(*s.material).
float transmission_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i);

}  // namespace tessera::core
