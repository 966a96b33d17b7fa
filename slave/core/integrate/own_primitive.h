// SPDX-License-Identifier: Apache-2.0
// The primitive that a surface's point lies on, for rays that leave the point.
//
// Threads. Pure functions; a list has one owner.
#pragma once

#include <cstdint>

#include "slave/core/ray/horizon_layout.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

struct OwnPrimitive {
  std::uint32_t number = kNoPrimitive;
  float horizon = kNoHorizon;
};

inline OwnPrimitive own_of(const Surface& s) { return {s.sound_primitive, s.horizon}; }

// Says of a ray in a list that it does not meet its own primitive, where that is known and worth
// saying: of planes, traversals find it out as fast. normal: unit, on the side of the ray.
// Rays: a RayList, or RayGroups of rays that end on the surface and are seen from there.
template <class Rays>
void exclude_own(Rays& rays, int place, OwnPrimitive own, Vec3f normal, Vec3f direction) {
  if (own.horizon == kPlaneHorizon) return;
  if (dot(normal, direction) > own.horizon * length(direction)) rays.exclude(place, own.number);
}

}  // namespace tessera::core
