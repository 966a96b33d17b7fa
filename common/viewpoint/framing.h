// SPDX-License-Identifier: Apache-2.0
// Places a camera that shows a whole scene. Its distance and place follow from the projection of
// the vertices themselves, not of a box. Vertices are those of triangles, and the points of the
// fine control nets between which freeform surfaces lie (patch_net.h).
//
// For a fixed direction and opening angle each vertex must lie inside four planes through the eye.
// Each plane is a linear constraint on the eye with the same normal for all vertices, so that of
// all vertices only the farthest along that normal binds, and the nearest eye is a closed form of
// four answers of the support mapping (framing.cpp).
//
// Threads. Pure functions.
#pragma once

#include "common/scene/camera.h"
#include "common/viewpoint/support_map.h"

namespace tessera {

// The part of the picture's width or height that a framed object takes up, whichever of the two it
// fills first: of the narrower side, unless the object is longer than the picture in the other
// direction.
inline constexpr double kFramedShare = 0.8;

struct Framing {
  Vec3d view{0, 0, -1};  // the way the camera looks; any length but zero
  Vec3d up{0, 1, 0};     // not parallel to it
  double vfov_degrees = 45;
  double aspect = 1;  // width / height
};

// The camera that looks along framing.view and in whose picture the vertices take up kFramedShare
// and lie in the middle, in both directions. Its target is on the line of sight halfway
// between the nearest and the farthest vertex. Exact but for the rounding of eye and target to
// float: with M their greatest coordinate and z the distance of the nearest vertex, a vertex is
// off by at most 2^-21 M / z of the picture's height times 1 + 1 / tan(vfov / 2).
//
// Nothing is left out: a single stray vertex is shown like all others. What has no extent across
// the view (a point, a line seen from its end) is seen from a distance of 1, or from as near as
// floats of its coordinates allow.
//
// Requires: !map.is_empty().
Camera framed_camera(const SupportMap& map, const Framing& framing);

}  // namespace tessera
