// SPDX-License-Identifier: Apache-2.0
// Packets of rays with origins of their own as kernels take them.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Requires: the packet outlives what is returned.
inline ManyRays many_of(const RayPacket& packet) {
  return {{packet.origin[0], packet.origin[1], packet.origin[2]},
          {packet.direction[0], packet.direction[1], packet.direction[2]},
          packet.t_min,
          packet.t_max,
          &packet.active,
          1,
          &packet.habit};
}

// Some of the packets. Requires: the arrays outlive what is returned.
inline ManyRays packets_from(const ManyRays& rays, int first, int count) {
  const int at = first * kPacketRays;
  return {{rays.origin[0] + at, rays.origin[1] + at, rays.origin[2] + at},
          {rays.direction[0] + at, rays.direction[1] + at, rays.direction[2] + at},
          rays.t_min + at,
          rays.t_max + at,
          rays.active + first,
          count,
          rays.habit,
          rays.excluded == nullptr ? nullptr : rays.excluded + at};
}

}  // namespace tessera::core
