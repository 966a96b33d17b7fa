// SPDX-License-Identifier: Apache-2.0
// References to primitives, which the builder of the hierarchy moves around and, where it splits in
// space, cuts.
//
// Threads. Ranges that do not overlap may be changed by different threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/uninitialized_allocator.h"
#include "slave/core/accel/box4.h"

namespace tessera::core {

// The box and the number of a primitive, which the builder moves around.
struct alignas(32) PrimitiveRef {
  float lower[3];
  std::uint32_t primitive;
  float upper[3];
  // The sum of both corners is taken on four lanes. A number read as a float is mostly denormal,
  // and sums of denormals take a hundred times as long; with this the fourth lane's is not.
  float one;
};

inline PrimitiveRef ref_of(const Bounds3f& box, std::uint32_t primitive) {
  return {{box.lower.x, box.lower.y, box.lower.z},
          primitive,
          {box.upper.x, box.upper.y, box.upper.z},
          1};
}

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

// Blocks of so many primitives each that `count` of them take.
inline float blocks_of(std::uint32_t count, std::uint32_t block_size) {
  return static_cast<float>((count + block_size - 1) / block_size);
}

// Shares the room behind both ranges out by their sizes, and moves the right one behind the room of
// the left. Requires: left.end == right.begin.
void share_room(std::span<PrimitiveRef> refs, RefRange& left, RefRange& right, std::uint32_t limit);

// References to primitives with a box, with room behind them. Memory is touched first by the thread
// that fills it.
struct References {
  std::vector<PrimitiveRef, UninitializedAllocator<PrimitiveRef>> refs;
  RefRange all;
};

// Refers to every step-th primitive, if its box is not empty, with room for a share of `cuts_max`
// more. Up to thread_count threads work; the order is that of the primitives. Throws:
// std::bad_alloc.
References refer_to(std::span<const Bounds3f> boxes, float cuts_max, int thread_count,
                    std::uint32_t step = 1);

}  // namespace tessera::core
