// SPDX-License-Identifier: Apache-2.0
// All patches of a scene version in world space, and the sub-patches that rays are tested against.
// Control points are brought there by the operations that bring vertices there, in float32; a patch
// in the world is the exact one of those points.
//
// Numbers. Patches are counted over the instances of surfaces, in order; sub-patches in the order
// of their patches. Among primitives that rays ask for, sub-patches stand in the place of their
// patch. Places that share a surface (room `placed`) have neither here, but the same numbers among
// those primitives.
//
// Threads. Filled once by make_patch_store(), then read by any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/large_pages.h"
#include "common/math/bounds3.h"
#include "common/scene/scene.h"
#include "slave/core/primitive/freeform/placed_parts_abi.h"
#include "slave/core/primitive/freeform/shared_surface.h"
#include "slave/core/primitive/instance_layout.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_preparation.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {

// Places that share surfaces. All is empty where every instance is flattened.
struct SharedPlaces {
  static constexpr std::uint32_t kFlattened = 0xffffffff;

  std::vector<std::shared_ptr<const SharedSurface>> surfaces;  // by surface of the scene, or null
  std::vector<std::uint32_t> of_instance;  // by instance: a place's number, or kFlattened
  std::vector<InstanceBlock> places;       // in order; `mesh`: the surface of the scene
  std::uint64_t first_number = 0;          // of the first place among those of all scenes

  bool has(std::size_t instance) const {
    return !of_instance.empty() && of_instance[instance] != kFlattened;
  }
  const InstanceBlock& place(std::size_t instance) const { return places[of_instance[instance]]; }
  const SharedSurface& surface(std::size_t instance) const {
    return *surfaces[place(instance).mesh];
  }
};

struct PatchStore {
  std::vector<std::shared_ptr<const TrimSet>> trims;  // by surface; null where nothing is trimmed
  // Control points of instances that are moved; those of others are the surface's own.
  std::vector<float, LastingAllocator<float>> numbers;
  std::vector<std::shared_ptr<const PatchSurface>> surfaces;
  std::vector<Patch> patches;
  std::vector<SubPatch, LastingAllocator<SubPatch>> parts;
  // [instance_count + 1]: the first patch and the first sub-patch of each instance; instances of
  // meshes have none. Empty where the scene has no surfaces.
  std::vector<std::uint64_t> first_patch, first_part;
  std::uint64_t degenerate_count = 0;  // patches that are one point, or beyond float32
  SharedPlaces shared;

  // Of an instance, wherever its patches are. Numbers of parts are those within the instance.
  std::uint64_t part_count(std::size_t instance) const {
    if (shared.has(instance)) return shared.surface(instance).parts.size();
    return first_part.empty() ? 0 : first_part[instance + 1] - first_part[instance];
  }
  std::uint64_t patch_count(std::size_t instance) const {
    if (shared.has(instance)) return shared.surface(instance).patches.size();
    return first_patch[instance + 1] - first_patch[instance];
  }
  // The number of a part's patch within the instance's surface.
  std::uint64_t patch_of_part(std::size_t instance, std::uint64_t part) const {
    if (shared.has(instance)) return shared.surface(instance).parts[part].patch;
    return parts[first_part[instance] + part].patch - first_patch[instance];
  }
  // A part in world space, with its patch; the answer holds until the thread asks again.
  PartInWorld part_at(std::size_t instance, std::uint64_t part) const;
  std::uint64_t memory_bytes() const;
};

// How patches of a scene with so many are split: small scenes for speed, large ones for memory. No
// answer depends on it but for roundings at silhouettes.
PatchSplitting splitting_for(std::uint64_t patch_count);

// Shape: boxes becomes those of the sub-patches, in world space. Sub-patches have no numbers as
// primitives yet. Requires: validate_scene(scene) is ok.
PatchStore make_patch_store(const Scene& scene, std::vector<Bounds3f>& boxes);
// The same, split as one likes. shared: instances that are not flattened.
PatchStore make_patch_store(const Scene& scene, const PatchSplitting& splitting,
                            std::vector<Bounds3f>& boxes, SharedPlaces shared = {});
// As the first one splits them: by the number of patches of the flattened scene.
PatchSplitting splitting_of(const Scene& scene);

}  // namespace tessera::core
