// SPDX-License-Identifier: Apache-2.0
// Spatial splits of a hierarchy's nodes: a plane cuts references in two, so that the boxes of both
// sides do not overlap there. Stich, Friedrich, Dietrich, "Spatial splits in bounding volume
// hierarchies", 2009.
//
// Invariant. The references of a range are of different primitives, for a split puts one part of a
// primitive on each side.
//
// Threads. One at a time per object.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "slave/core/accel/primitive_set.h"
#include "slave/core/accel/sah_bins.h"

namespace tessera::core {

struct SpatialCut {
  int axis = -1;  // -1: no plane has something on either side, or there is no room for the parts
  float plane = 0;
  float cost = 0;  // as SahCut has it
};

class SpatialSplitter {
 public:
  static constexpr int kBins = 16;

  // Requires: the clipper outlives it.
  explicit SpatialSplitter(const PrimitiveClipper& clipper) : clipper_(clipper) {}

  // Chooses the cheapest of the planes between bins of equal width, whose parts fit into the room
  // of `range`.
  SpatialCut cut(std::span<const PrimitiveRef> refs, const RefRange& range,
                 std::uint32_t block_size);

  // Cuts the references that stand on both sides of the plane, and orders them. The room that is
  // left is shared out by their numbers. Returns: left and right part; neither is empty.
  // Requires: range.size() > 1, cut.axis >= 0.
  std::pair<RefRange, RefRange> split(std::span<PrimitiveRef> refs, const RefRange& range,
                                      const SpatialCut& cut) const;

 private:
  struct Bin {
    Box4 bounds;
    std::uint32_t begins = 0, ends = 0;  // references whose box begins here; that ends here
  };
  void fill(std::span<const PrimitiveRef> refs, const RefRange& range);
  // Shares the box of a reference out to the slabs that it reaches across.
  void fill_slabs(const PrimitiveRef& ref, const RefRange& range, int axis, int first, int last);
  void cut_in_two(PrimitiveRef& ref, const SpatialCut& cut, std::span<PrimitiveRef> refs,
                  std::uint32_t& end, std::uint32_t limit) const;

  const PrimitiveClipper& clipper_;
  Bin bins_[3][kBins];
};

}  // namespace tessera::core
