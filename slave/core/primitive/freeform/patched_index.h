// SPDX-License-Identifier: Apache-2.0
// Scenes with patches: one hierarchy over their sub-patches and over triangles, all in world space.
//
// Threads. Built by the calling thread and up to thread_count - 1 more.
#pragma once

#include <cstdint>
#include <span>

#include "common/base/status.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// What the hierarchy is built over. Shape: boxes [triangle_count], an empty one stays out; vertices
// [triangle_count][3][3]; numbers [triangle_count]: of the triangles among primitives that rays ask
// for; part_boxes [part_count].
struct PatchedParts {
  std::span<const Bounds3f> boxes;
  std::span<const float> vertices;
  std::span<const std::uint32_t> numbers;
  std::span<const Bounds3f> part_boxes;
};

// Requires: sub-patches of the store have their numbers. Returns: kCancelled; kResourceExhausted.
template <int W>
Result<PatchedBvh<W>> index_patches(const PatchedParts& parts,
                                    std::shared_ptr<const PatchStore> patches,
                                    const BuildControl& control);

}  // namespace tessera::core
