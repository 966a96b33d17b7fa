// SPDX-License-Identifier: Apache-2.0
// Varnish and sheen on top of a surface, for code that looks at one surface at a time; the kernels
// have the whole lobes (slave/core/bsdf/layered-inl.h).
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// Returns: the share of light from below that the layers pass to the viewer. normal: the surface's,
// unit, for sheen.
float passed_by_layers(const SurfaceLobes& lobes, Vec3f normal, Vec3f to_viewer);

}  // namespace tessera::core
