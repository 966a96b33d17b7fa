// SPDX-License-Identifier: Apache-2.0
// What textures, vertices and constants of a material make of its optional lobes at a point.
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/detail_layout.h"
#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// Of point i, which `group` made. Requires: has_lobes(*s.material).
SurfaceLobes lobes_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i);

// The share of the surface at point i that passes light. Requires: passes_light(*s.material).
float transmission_of(const Surface& s, const DetailGroup& group, const DetailPoints& points,
                      int i);

}  // namespace tessera::core
