// SPDX-License-Identifier: Apache-2.0
// All patches of a scene version in world space, and the sub-patches that rays are tested against.
// Control points are brought there by the operations that bring vertices there, in float32; a patch
// in the world is the exact one of those points.
//
// Numbers. Patches are counted over the instances of surfaces, in order; sub-patches in the order
// of their patches. Among primitives that rays ask for, sub-patches stand in the place of their
// patch.
//
// Threads. Filled once by make_patch_store(), then read by any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/bounds3.h"
#include "common/scene/scene.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_preparation.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {

struct PatchStore {
  std::vector<std::shared_ptr<const TrimSet>> trims;  // by surface; null where nothing is trimmed
  // Control points of instances that are moved; those of others are the surface's own.
  std::vector<float> numbers;
  std::vector<std::shared_ptr<const PatchSurface>> surfaces;
  std::vector<Patch> patches;
  std::vector<SubPatch> parts;
  // [instance_count + 1]: the first patch and the first sub-patch of each instance; instances of
  // meshes have none. Empty where the scene has no surfaces.
  std::vector<std::uint64_t> first_patch, first_part;
  std::uint64_t degenerate_count = 0;  // patches that are one point, or beyond float32

  bool is_empty() const { return patches.empty(); }
  std::uint64_t part_count(std::size_t instance) const {
    return first_part.empty() ? 0 : first_part[instance + 1] - first_part[instance];
  }
  std::uint64_t memory_bytes() const;
};

// How patches of a scene with so many are split: small scenes for speed, large ones for memory. No
// answer depends on it but for roundings at silhouettes.
PatchSplitting splitting_for(std::uint64_t patch_count);

// Shape: boxes becomes those of the sub-patches, in world space. Sub-patches have no numbers as
// primitives yet. Requires: validate_scene(scene) is ok.
PatchStore make_patch_store(const Scene& scene, std::vector<Bounds3f>& boxes);
// The same, split as one likes.
PatchStore make_patch_store(const Scene& scene, const PatchSplitting& splitting,
                            std::vector<Bounds3f>& boxes);

}  // namespace tessera::core
