// SPDX-License-Identifier: Apache-2.0
// Chooses the split plane of one voxel by the surface area heuristic. Pure functions; scratch
// memory is the caller's.
//
// Threads. The primitives of a voxel may be looked at in parts by several threads: parts are
// counted and sorted, and the plane does not depend on their number.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/work_gate.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/kd_build_config.h"
#include "slave/core/accel/run_tasks.h"

namespace tessera::core {

// Faces on one axis, sorted; flats: boxes of zero thickness.
struct SahFaces {
  std::vector<float> lowers, uppers, flats;
  // Numbers of boxes that have begun and ended below the faces.
  std::size_t begun = 0, ended = 0;
};

// How many boxes begin and end in each bin of an axis.
struct KdBins {
  std::array<std::uint32_t, kKdBinsMax> begins, ends;
};

// Memory reused from voxel to voxel; owned by one thread.
struct SahScratch {
  SahFaces faces[3];
  KdBins bins[3];
  Bounds3f tight;
  std::vector<SahScratch> parts;  // of what several threads look at
};

// The boxes of a voxel's primitives.
struct WholeBoxes {
  const Bounds3f* all;  // [primitive_count]
  std::span<const std::uint32_t> primitives;

  std::size_t size() const { return primitives.size(); }
  const Bounds3f& operator[](std::size_t i) const { return all[primitives[i]]; }
  WholeBoxes subspan(std::size_t first, std::size_t count) const {
    return {all, primitives.subspan(first, count)};
  }
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

// Calls work(part, some) for the boxes in so many parts, on up to thread_count threads.
template <class Boxes, class Work>
void in_parts(const Boxes& boxes, std::size_t parts, int thread_count, const Work& work) {
  if (parts == 1) return work(std::size_t{0}, boxes);
  const std::size_t size = (boxes.size() + parts - 1) / parts;
  run_tasks(static_cast<int>(parts), thread_count, [&](int i) {
    give_way();
    const auto part = static_cast<std::size_t>(i);
    const std::size_t first = std::min(part * size, boxes.size());
    work(part, boxes.subspan(first, std::min(size, boxes.size() - first)));
  });
}

// Requires: every box touches the voxel. Boxes: WholeBoxes or PartBoxes, looked at in so many parts
// where they are more than config.sweep_max.
template <class Boxes>
SahSplit choose_split(const Boxes& boxes, const Bounds3f& voxel, const KdBuildConfig& config,
                      SahScratch& scratch, std::size_t parts = 1, int thread_count = 1);

}  // namespace tessera::core
