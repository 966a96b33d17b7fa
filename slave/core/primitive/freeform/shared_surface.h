// SPDX-License-Identifier: Apache-2.0
// A surface of patches without trims in its own coordinates ("object space"), split once for all
// the places that share it. Sub-patches are numbered as those of a flattened place are.
//
// Threads. Made by one thread, then never changed; versions of a scene share it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/bounds3.h"
#include "common/math/transform.h"
#include "common/scene/scene.h"
#include "common/scene/surface_sharing.h"
#include "slave/core/primitive/instance_layout.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_preparation.h"

namespace tessera::core {

struct SharedSurface {
  std::shared_ptr<const PatchSurface> surface;
  double radius = 0;            // of the splitting: splittings differ where this does
  std::vector<Patch> patches;   // numbers are the surface's; null where a patch has no extent
  std::vector<SubPatch> parts;  // `patch` and `primitive` are numbers within the surface
  std::vector<Bounds3f> boxes;  // [part], object space
  Bounds3f points;  // box of the control points of patches that have an extent, and 2^-12 more
  SurfaceReach reach;
  std::uint64_t degenerate_count = 0;  // patches that have no extent

  std::uint64_t memory_bytes() const;
};

// Requires: the surface has no trims.
SharedSurface shared_surface(std::shared_ptr<const PatchSurface> surface,
                             const PatchSplitting& splitting);

// The map of a place.
Transform to_world_of(const InstanceBlock& place);

std::size_t number_count_of(const Patch& patch);

// Brings control points to world space in float32, as vertices are. Shape: numbers [point][x, y,
// z], and a weight where is_rational; box grows by the points.
void place_points(const Transform& to_world, bool is_rational, std::size_t number_count,
                  float* numbers, Bounds3f& box);

// Brings a part and its patch, both in their own place, to the world as they are flattened. Shape:
// numbers has room for the patch's, which `patch` names afterwards; box, of the part, becomes one
// in the world. Requires: the map leaves the patch an extent.
SubPatch place_part(const Transform& to_world, const SubPatch& part, Patch& patch, float* numbers,
                    Bounds3f& box);

}  // namespace tessera::core
