// SPDX-License-Identifier: Apache-2.0
// A point that sheds light, as kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/ray/horizon_layout.h"

namespace tessera::core {

// Kinds of light that is shed from one place: shares of a surface (a VPL proper, or a point of an
// area light), delta lights, and light from so far away that its rays are parallel.
enum class LightPointKind : int32_t {
  kSurface = 0,
  kPoint = 1,
  kSpot = 2,
  kFar = 3,
  kEmitter = 4  // as kSurface, of an area light
};

struct LightPoint {
  float position[3];  // kFar: none, see begin_gather()
  // Unit. kSurface, kEmitter: the side that sheds; kSpot, kFar: the way light travels.
  float normal[3];
  // The light that is shed. kSurface, kEmitter: radiance times area, W/sr along the normal; kPoint,
  // kSpot: W/sr; kFar: irradiance of a surface that faces it.
  float rgb[3];
  float cos_inner, cos_outer;  // kSpot, see Light
  float t_min;                 // of shadow rays that leave it
  LightPointKind kind;
  // kSurface, kEmitter: the primitive that the point lies on, and how steep rays are that do not
  // meet it again (horizon_layout.h). None for slivers.
  uint32_t primitive = 0xffffffffu;
  float horizon = kPlaneHorizon;
};

}  // namespace tessera::core
