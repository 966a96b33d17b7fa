// SPDX-License-Identifier: Apache-2.0
// Whether a scene is a room, or rooms, rather than a thing to be looked at from outside.
//
// A point is in a room when of the six rays along the axes from it at least five meet fronts: walls
// are made to be seen from there, and one side may be open. Inside a solid (a bunny, a cloud) rays
// meet backs; beside a thing, at most some of them meet anything. A scene is an interior when
// - more than half of its box is in rooms; or more than a third, and more than half of its surface
//   is next to a point in a room (a church with thick walls and much carving inside; a teapot,
//   whose inner side is smaller than its outer, is not one),
// - and it is not open from above, as a floor plan without ceilings is.
// A side is open when from outside, along that side's normal, more than half of the rays meet a
// front first and behind the middle of the box: one looks into it as onto a stage.
//
// README.md lists the scenes that the rule was tried on, and their shares.
//
// Threads. Pure functions.
#pragma once

#include "common/viewpoint/axis_rays.h"

namespace tessera {

struct InteriorEvidence {
  double room_volume = 0;   // share of the box that is in rooms
  double room_surface = 0;  // share of the surface that rooms show
  // [Axis], of the rays along it from outside: `depth` is the share that goes far in, `fronts` the
  // share that meets fronts among those that meet anything.
  std::array<double, 6> depth{}, fronts{};

  bool is_open(Axis axis) const { return depth[static_cast<std::size_t>(axis)] > 0.5; }
  // The direction in which one looks at the scene's front: the first of -z (from +z, where glTF has
  // it), +z, -x, +x in which most of what is met are fronts; -z where there is none.
  Axis view() const {
    for (const Axis axis : {Axis::kAhead, Axis::kBack, Axis::kLeft, Axis::kRight})
      if (fronts[static_cast<std::size_t>(axis)] > 0.5) return axis;
    return Axis::kAhead;
  }
  bool is_interior() const {
    const bool is_room = room_volume > 0.5 || (room_volume > 1.0 / 3 && room_surface > 0.5);
    return is_room && !is_open(Axis::kDown);
  }
};

bool is_in_room(const AxisRays& rays, int index);

InteriorEvidence evidence_of(const AxisRays& rays);

}  // namespace tessera
