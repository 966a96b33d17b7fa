// SPDX-License-Identifier: Apache-2.0
// Builds a wide bounding volume hierarchy in little time, for scenes of which every version is
// another one: the rays of one frame have to pay for it.
//
// Method. References are sorted into a grid, the top of the hierarchy is built over its cells
// (grid_sort.h), and below, a range is cut at the cheapest of a few bins on the axis on which its
// centroids reach furthest. bvh_builder.h has the builder for scenes that last.
//
// Threads. The calling thread and up to thread_count - 1 more; the result does not depend on their
// number.
#pragma once

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"

namespace tessera::core {

// Requires: no primitive of the set takes a leaf of its own. Returns: kCancelled;
// kResourceExhausted when indices or memory run out.
template <int W>
Result<Bvh<W>> build_bvh_fast(const PrimitiveSet& set, const BuildControl& control);

}  // namespace tessera::core
