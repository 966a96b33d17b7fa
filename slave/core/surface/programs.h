// The freely programmable part of surfaces: a program is told where a ray has hit and fills in what
// it likes of the Surface, here the albedo. It knows nothing of how the BSDF uses that.
//
// Programs are one small file each; their parameters stand in common/scene/surface_program.h. The
// same bits everywhere: arithmetic, square roots and floor only.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"

namespace tessera::core {

// In object space, so that patterns stay with the mesh.
struct SurfacePlace {
  Vec3f point;
  Vec3f normal;         // geometric; need not be of unit length
  float footprint = 0;  // width of what the pixel sees, 0 unknown
};

// Requires: albedo holds the material's colour, times its texture's; the program's parameters are in
// their ranges.
void apply_surface_program(const SurfaceProgram& program, const SurfacePlace& place, Surface& s);

void apply_marble(const SurfaceParameters& parameters, const SurfacePlace& place, Surface& s);
void apply_wood(const SurfaceParameters& parameters, const SurfacePlace& place, Surface& s);
void apply_brick(const SurfaceParameters& parameters, const SurfacePlace& place, Surface& s);

}  // namespace tessera::core
