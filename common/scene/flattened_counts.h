// SPDX-License-Identifier: Apache-2.0
// How much a scene's instances make of meshes and surfaces, and how much they may.
// Threads. Plain values; pure functions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera {

struct FlattenedCounts {
  std::uint64_t triangles = 0, patches = 0;
  std::uint64_t segments = 0;  // of the patches' trimming loops

  FlattenedCounts& operator+=(const FlattenedCounts& other);
  FlattenedCounts& operator-=(const FlattenedCounts& other);
};

FlattenedCounts flattened_counts(const Mesh& mesh);
FlattenedCounts flattened_counts(const PatchSurface& surface);
// Requires: the instance's mesh or surface is there.
FlattenedCounts flattened_counts(const Scene& scene, const Instance& instance);

// Blocks in which a scene travels, with the environment map and the animation that it may have.
std::size_t block_count_max(const Scene& scene);

// Returns: kResourceExhausted naming the limit.
Status validate_flattened(const FlattenedCounts& counts);

}  // namespace tessera
