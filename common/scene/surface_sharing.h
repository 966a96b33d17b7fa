// SPDX-License-Identifier: Apache-2.0
// Which places may share a surface of patches that is split once for all of them. Slaves ask before
// they build, and whoever reckons what they take asks the same (scene_footprint.h).
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "common/math/transform.h"
#include "common/scene/patch_surface.h"

namespace tessera {

// How far the control points of a surface are apart, in its own coordinates.
struct SurfaceReach {
  std::array<double, 3> largest{};  // by axis, the largest size of a coordinate
  // The least of the longest sides of patches' boxes, but for patches that are one point.
  double least_extent = std::numeric_limits<double>::infinity();
};

// Numbers beyond what the forms ask for are left out, as are patches that have too few.
SurfaceReach reach_of(std::span<const PatchForm> patches, std::span<const float> numbers);

// Whether a place may share the surface: the map has an inverse in float32, with values that are
// far from the ends of it, and leaves each patch an extent that is more than roundings.
bool may_share(const SurfaceReach& surface, const Transform& to_world);

}  // namespace tessera
