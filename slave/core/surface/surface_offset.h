// SPDX-License-Identifier: Apache-2.0
// Where secondary rays start, for plain numbers, by the text of surface_point-inl.h, which derives
// the bounds.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "common/math/vec3.h"
#include "slave/core/surface/surface_point-inl.h"

namespace tessera::core {

using plain::is_sliver;
using plain::kSliverSine2;
using plain::surface_point;
using SurfacePoint = plain::SurfacePoint<float>;

}  // namespace tessera::core
