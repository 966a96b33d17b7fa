// SPDX-License-Identifier: Apache-2.0
// Fits a hierarchy to primitives that have moved since it was built: nodes and leaves stay what
// they are, and boxes are made anew from the leaves up. A fitted hierarchy gives the answers of a
// built one, but its rays may take longer, which sah_cost() estimates.
//
// Threads. The calling thread and up to thread_count - 1 more; the result does not depend on their
// number.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "slave/core/accel/box4.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

// Writes the blocks of a hierarchy again, with the primitives that they have, where those are now.
class LeafFitter {
 public:
  virtual ~LeafFitter() = default;
  // May be called by any thread, once for each leaf. Returns: the box of the leaf's primitives.
  virtual Box4 fit(const LeafRange& leaf) const = 0;
};

// What a ray that meets the hierarchy's box costs, by the surface area heuristic: the area of each
// child's box to that of the whole, times 1 for a node and the number of blocks for a leaf. The sum
// is taken in one order, so that it has the same bits everywhere. 0 for a box without area.
template <int W>
double sah_cost(const Bvh<W>& bvh);

// Returns: kCancelled; kResourceExhausted when memory runs out.
template <int W>
Result<Bvh<W>> fit_bvh(const Bvh<W>& built, const LeafFitter& leaves, const BuildControl& control);

}  // namespace tessera::core
