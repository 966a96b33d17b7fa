// SPDX-License-Identifier: Apache-2.0
// Where the rays of a packet have met surfaces, as the kernels find them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Arrays by ray, set for the rays that have met something.
struct alignas(64) PacketPoints {
  float point[3][kPacketRays];
  float normal[3][kPacketRays];  // geometric, unit, turned to the viewer
  float offset[kPacketRays];     // see surface_offset.h
  float horizon[kPacketRays];    // see horizon_layout.h; set for rays that have met patches
  float u[kPacketRays], v[kPacketRays];
  float distance[kPacketRays];  // from the ray's origin
  uint64_t met;                 // bits of the rays that have met something
  uint64_t front;               // bits: the ray goes against the geometric normal of the mesh
  uint64_t sliver;              // bits: see is_sliver() in surface_offset.h, and without horizon
};

}  // namespace tessera::core
