// SPDX-License-Identifier: Apache-2.0
// What the programs of this folder trace: one kernel, taken from the table that holds them all, or
// compiled alone.
#pragma once

#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

struct FeatureScene {
  BvhView<8, TrianglesOnly<8>> bvh;
  KdView<8, TrianglesOnly<8>> kd;
};

// Closest hits, or the bits of the rays that are blocked: whichever the program has.
uint64_t trace_once(const FeatureScene& scene, const FanPacket& rays, PacketHits& hits);

}  // namespace tessera::core
