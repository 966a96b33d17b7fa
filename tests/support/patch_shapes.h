// SPDX-License-Identifier: Apache-2.0
// Shapes of patches to test with: spheres, cylinders, cones and tori as exact rationals, the teapot
// of builtin:teapot, planes, folds, cusps, high degrees; prepared, and asked by brute force.
//
// Threads. Owned by one test.
#pragma once

#include <string>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/primitive/patch/patch_hit.h"
#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_preparation.h"

namespace tessera::test {

// The sphere's radius is 1; cylinder and cone have it at z = -1 and end at z = 1, with discs; the
// torus turns a circle of radius kTubeRadius about the z axis at distance 1.
inline constexpr float kTubeRadius = 0.4f;

// Names: sphere cylinder cone torus teapot, which has 32 bicubic patches; plane plane33 cusp fold
// sheets degree15x9 weights (from 2^-6 to 2^6 side by side) and weights4x5, one patch each.
std::vector<core::CheckedPatch> patch_shape(const std::string& name);

// The same as other numbers of float32: x -> scale x + shift, by axis. Shared points stay shared.
std::vector<core::CheckedPatch> moved(const std::vector<core::CheckedPatch>& patches, float scale,
                                      float shift);

// Patches with their parts.
class PatchScene {
 public:
  struct Hit : core::PatchHit {
    std::uint32_t patch = 0, part = 0;
  };

  explicit PatchScene(std::vector<core::CheckedPatch> patches,
                      const core::PatchSplitting& splitting = {});

  std::size_t patch_count() const { return patches_.size(); }
  core::Patch patch(std::size_t number) const { return patches_[number].patch(); }
  const core::SubPatches& parts() const { return parts_; }
  const Bounds3f& bounds() const { return bounds_; }
  const Bounds3f& bounds(std::size_t patch) const { return of_patches_[patch].box; }

  // The nearest hit, of equal ones the lowest part's. Counts rays, and those for which some part
  // asked the complete solver.
  Hit trace(const core::PatchRay& ray, core::CompleteSolver& solver);
  std::size_t ray_count() const { return ray_count_; }
  std::size_t open_ray_count() const { return open_ray_count_; }

 private:
  struct PatchParts {
    Bounds3f box;
    std::size_t first = 0, end = 0;
  };

  std::vector<core::CheckedPatch> patches_;
  core::SubPatches parts_;
  std::vector<PatchParts> of_patches_;
  Bounds3f bounds_;
  std::size_t ray_count_ = 0, open_ray_count_ = 0;
};

// Whether a ray passes a box, which is wider by `slack`, within [t_min, t_max].
bool passes(const core::PatchRay& ray, const Bounds3f& box, double slack, double t_max);

}  // namespace tessera::test
