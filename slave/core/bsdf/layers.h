// SPDX-License-Identifier: Apache-2.0
// Varnish and sheen on top of a surface, for what is asked one surface at a time; the kernels have them
// whole (slave/core/bsdf/layered-inl.h).
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// The share of light from below that comes through them to the viewer. normal: of the surface, for sheen;
// unit.
float passed_by_layers(const SurfaceLobes& lobes, Vec3f normal, Vec3f to_viewer);

}  // namespace tessera::core
