// SPDX-License-Identifier: Apache-2.0
// The kernel that the programs of this folder trace with. It is taken from the table that holds all
// kernels, or compiled alone.
#pragma once

#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

struct FeatureScene {
  BvhView<8, TrianglesOnly<8>> bvh;
  KdView<8, TrianglesOnly<8>> kd;
};

// Traces closest hits into `hits`, or returns the bits of the rays that are blocked, whichever the
// program was compiled for.
uint64_t trace_once(const FeatureScene& scene, const Fan& rays, const HitArrays& hits);

}  // namespace tessera::core
