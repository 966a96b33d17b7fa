// SPDX-License-Identifier: Apache-2.0
// Glossy surfaces that pass a part of the light: which part a ray meets is left to chance.
//
// The BSDF of such a surface is a mean of an opaque one and of a transparent dielectric, by `share`, and of
// metal (KHR_materials_transmission: all that is no metal and would be diffuse is passed on). A ray meets
//   - with a chance of the opaque part: that, glossy with all lobes, more of a metal than the whole;
//   - else, a smooth one: glass, which chooses between its two directions when light is scattered
//     (specular.h);
//   - else what the outside of a rough one reflects: a glossy surface without a base, so that samples of
//     lights find highlights; or what it passes: glass that passes only. The chance of the first is
//     (1 + 3 F) / 4, F the reflectance of the smooth surface: no sample weighs more than four times, nor
//     highlights more than they do elsewhere.
// The weight of the surface is the inverse of the last chance. Emission is the same whatever the ray meets
// and is not to be weighed. Inside of a solid one no light sample finds anything: a rough one is glass
// both ways there.
//
// Varnish and sheen dim what passes below them by what they reflect in the viewer's direction.
//
// Absorption. What a ray meets from inside has been dimmed on the way by Beer's law; the surface's weight
// has that.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"

namespace tessera::core {

// The share, in [0, 1], of s that passes light where it is no metal; `chance` in [0, 1). lobes: its own, or
// null. Requires: s is glossy and complete, but for its weight, which becomes what is said above.
void choose_part(Surface& s, SurfaceLobes* lobes, float share, float chance);

// What is left of light after `distance` inside.
Vec3f absorbed(const Transmission& inside, float distance);

}  // namespace tessera::core
