// SPDX-License-Identifier: Apache-2.0
// Primitives sorted into bins by their centroid, and the cheapest border between two bins. The
// builder of the bounding volume hierarchy uses them.
//
// Threads. One thread at a time per object.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "slave/core/accel/box4.h"

namespace tessera::core {

// The box and the number of a primitive, which the builder moves around.
struct alignas(32) PrimitiveRef {
  float lower[3];
  std::uint32_t primitive;
  float upper[3];
  // The sum of both corners is taken on four lanes. A number read as a float is mostly denormal,
  // and sums of denormals take a hundred times as long; with this the fourth lane's is not.
  float one = 1;
};

// A run of references, the box of their boxes and the box of their doubled centroids. There is room
// behind it, up to `limit`, for the parts of references that splits of the run cut in two.
struct RefRange {
  std::uint32_t begin = 0, end = 0, limit = 0;
  Box4 bounds, centroids;

  std::uint32_t size() const { return end - begin; }
  std::uint32_t room() const { return limit - end; }
  void grow(const PrimitiveRef& ref) {
    const Float4 lower = load4(ref.lower), upper = load4(ref.upper);
    bounds.grow(lower, upper);
    centroids.grow(lower + upper, lower + upper);
  }
};

// Shares the room behind both ranges out by their sizes, and moves the right one behind the room of
// the left. Requires: left.end == right.begin.
void share_room(std::span<PrimitiveRef> refs, RefRange& left, RefRange& right, std::uint32_t limit);

struct SahCut {
  int axis = -1;         // -1: all centroids coincide
  int bin = 0;           // references of this bin and those before go left
  float cost = 0;        // blocks below, weighed by area
  Box4 left{}, right{};  // of the references on each side
};

class SahBins {
 public:
  static constexpr int kBinsMax = 32;

  // Chooses the cheapest cut of `range`; the cost of leaves is counted in blocks of `block_size`.
  SahCut cut(std::span<const PrimitiveRef> refs, const RefRange& range, std::uint32_t block_size);

  // Orders the references of `range` by the cut, or halves them where there is none. Returns: left
  // and right part; neither is empty. Requires: range.size() > 1.
  static std::pair<RefRange, RefRange> split(std::span<PrimitiveRef> refs, const RefRange& range,
                                             const SahCut& cut);

 private:
  struct Bin {
    Box4 bounds;
    std::uint32_t count = 0;

    void add(Float4 lower, Float4 upper) {
      bounds.grow(lower, upper);
      ++count;
    }
  };
  // Sorts `refs`, those of `range`, into the first set.
  void fill(std::span<const PrimitiveRef> refs, const RefRange& range);

  Bin bins_[2][3][kBinsMax];
};

}  // namespace tessera::core
