// SPDX-License-Identifier: Apache-2.0
// Packets and hits as kernels take them.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Requires: the packet outlives what is returned.
inline Fan fan_of(const FanPacket& packet) {
  return {{packet.direction[0], packet.direction[1], packet.direction[2]},
          packet.t_max,
          {packet.origin[0], packet.origin[1], packet.origin[2]},
          packet.t_min,
          packet.active,
          packet.entry,
          &packet.habit};
}

inline HitArrays arrays_of(PacketHits& hits) { return {hits.t, hits.primitive}; }

}  // namespace tessera::core
