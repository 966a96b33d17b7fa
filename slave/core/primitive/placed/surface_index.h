// SPDX-License-Identifier: Apache-2.0
// The hierarchy of a shared surface of patches, in its own coordinates; versions of a scene share
// it.
//
// Threads. Built by the calling thread and up to thread_count - 1 more, then never changed.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/status.h"
#include "slave/core/primitive/freeform/shared_surface.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

template <int W>
struct SurfaceIndex {
  std::shared_ptr<const SharedSurface> surface;
  Bvh<W> structure;
  std::vector<std::uint32_t> blocks;  // as SurfaceShape has them

  SurfaceShape<W> shape() const;
  std::uint64_t memory_bytes() const {
    return structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t);
  }
};

// Requires: the surface has sub-patches. Returns: kCancelled; kResourceExhausted.
template <int W>
Result<std::shared_ptr<const SurfaceIndex<W>>> index_surface(
    std::shared_ptr<const SharedSurface> surface, const BuildControl& control);

}  // namespace tessera::core
