// SPDX-License-Identifier: Apache-2.0
// Chooses the split plane of one voxel by the surface area heuristic. Pure functions; scratch
// memory is the caller's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/accel/kd_build_config.h"

namespace tessera::core {

// Memory reused from voxel to voxel; owned by one thread.
struct SahScratch {
  // Faces on one axis, sorted; flats: boxes of zero thickness.
  std::vector<float> lowers, uppers, flats;
};

// The boxes of a voxel's primitives.
struct WholeBoxes {
  const Bounds3f* all;  // [primitive_count]
  std::span<const std::uint32_t> primitives;

  std::size_t size() const { return primitives.size(); }
  const Bounds3f& operator[](std::size_t i) const { return all[primitives[i]]; }
};
// The boxes of the parts of primitives that lie in the voxel.
using PartBoxes = std::span<const Bounds3f>;

struct SahSplit {
  int axis = -1;  // -1: no plane is cheaper than a leaf
  float plane = 0;
  float cost = 0;
};

// Whether a primitive goes to the lower or to the upper side of a plane, by the extent of its part
// on the plane's axis. A flat box in the plane goes below.
inline bool goes_below(float lower, float plane, float upper) {
  return lower < plane || (lower == plane && upper == plane);
}
inline bool goes_above(float plane, float upper) { return upper > plane; }

// Requires: every box touches the voxel. Boxes: WholeBoxes or PartBoxes.
template <class Boxes>
SahSplit choose_split(const Boxes& boxes, const Bounds3f& voxel, const KdBuildConfig& config,
                      SahScratch& scratch);

}  // namespace tessera::core
