// SPDX-License-Identifier: Apache-2.0
// The freely programmable part of surfaces: a program is told where rays have hit and fills in
// members of the Surfaces, here the albedo, but does not change their geometry and normals. It
// knows nothing of how the BSDF uses its values.
//
// Programs are one small file each; their parameters stand in common/scene/surface_program.h. They
// see many places at a time, so that noise is made by registers (noise.h). Results are the same to
// the bit everywhere and whatever places are computed together, since only arithmetic, square roots
// and floor are used.
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <span>

#include "slave/core/surface/noise.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

inline constexpr int kPlacesMax = kNoisePoints;

// Places in object space, so that patterns stay with the mesh. Shape of all: [places], at most
// kPlacesMax.
struct SurfacePlaces {
  using Axes = std::array<std::span<const float>, 3>;
  Axes point;
  Axes normal;                       // geometric; need not be of unit length
  std::span<const float> footprint;  // width of what the pixel sees, finite; 0 unknown
  std::span<Surface* const> surface;
};

// Requires: albedo holds the material's colour, times its texture's; the program's parameters are
// in their ranges.
void apply_surface_program(const SurfaceProgram& program, const Noise& noise,
                           const SurfacePlaces& places);

void apply_marble(const SurfaceParameters& parameters, const Noise& noise,
                  const SurfacePlaces& places);
void apply_wood(const SurfaceParameters& parameters, const Noise& noise,
                const SurfacePlaces& places);
void apply_brick(const SurfaceParameters& parameters, const SurfacePlaces& places);

}  // namespace tessera::core
