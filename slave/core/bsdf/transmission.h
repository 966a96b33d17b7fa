// SPDX-License-Identifier: Apache-2.0
// Glossy surfaces that pass a part of the light. Which part of the surface a ray meets is left to
// chance.
//
// The BSDF of such a surface is a mean of metal, of an opaque dielectric and, by `share`, of a
// transparent one (KHR_materials_transmission: all light that would be diffuse where the surface is
// no metal is passed on). A ray meets one of these:
//   - the opaque part, by its share of the surface: glossy with all lobes, and more of a metal than
//     the whole;
//   - otherwise, on a smooth surface without varnish and sheen, glass, which chooses between its
//     two directions when light is scattered (specular.h);
//   - otherwise, on the outside of a surface, either what it reflects, a glossy surface without a
//     base, so that light samples find highlights; or what it passes, glass that passes only. The
//     chance of the former is (1 + 3 F) / 4, with F the reflectance of the smooth surface, so that
//     no sample weighs more than four times, and highlights no more than they do elsewhere.
// The surface's weight is multiplied by the inverse of the last chance. Emission is the same
// whatever the ray meets and is not to be weighed. Inside of a solid no light sample finds
// anything, so a rough surface is glass in both directions there.
//
// Varnish and sheen dim what passes below them by what they reflect in the viewer's direction.
//
// Absorption. Light from a surface that a ray meets from inside has been dimmed on the way by
// Beer's law; the surface's weight contains that factor.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// Chooses the part of s that a ray meets, and makes s that part. share: what part of s, where s is
// no metal, passes light, in [0, 1]; chance: in [0, 1); lobes: those of s, or null. Requires: s is
// glossy and complete; its weight is multiplied as is said above.
void choose_part(Surface& s, SurfaceLobes* lobes, float share, float chance);

// Returns: the share of light that is left after `distance` inside.
Vec3f absorbed(const Transmission& inside, float distance);

}  // namespace tessera::core
