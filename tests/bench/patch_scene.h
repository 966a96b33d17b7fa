// SPDX-License-Identifier: Apache-2.0
// Teapots as patches and as triangles, for the suite "patch": the 32 bicubic patches of
// builtin:teapot, one by itself, or many in a square field.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "tests/bench/contender.h"
#include "tests/bench/workload.h"

namespace tessera::bench {

// A square field of teapots, side x side.
Scene teapot_field(int side);
Camera camera_of_field(int side);
Vec3f light_of_field(int side);

// Each patch as cells x cells squares of two triangles. Triangles of a patch follow each other, row
// by row of u. Shape: boxes becomes those of the triangles.
core::TriangleStore tessellated(const core::PatchStore& patches, int cells,
                                std::vector<Bounds3f>& boxes);
// The same patches by points of B-splines, rounded to float32. Requires: they are bicubic and not
// rational.
SplinePatches splines_of(const core::PatchStore& patches);
// Megabytes of the same triangles as a mesh whose vertices are shared within a patch.
double mesh_megabytes(const core::PatchStore& patches, int cells);

// Patches, asked by brute force.
class PatchTruth {
 public:
  // Requires: both outlive it, and boxes are those of the store's parts.
  PatchTruth(const core::PatchStore& patches, const std::vector<Bounds3f>& boxes);

  struct Hit {
    bool is_hit = false;
    float t = 0;
    std::uint32_t primitive = 0;  // the sub-patch
  };
  // The nearest hit, of equal ones the lowest sub-patch's.
  Hit trace(Vec3f origin, Vec3f direction) const;

  // An upper bound of the distance of a point from a patch, by steps from (u, v) to the nearest
  // point.
  double distance(std::uint32_t patch, double u, double v, const double (&point)[3]) const;
  // The diagonal of one teapot's box.
  double diagonal() const { return diagonal_; }

 private:
  const core::PatchStore& patches_;
  const std::vector<Bounds3f>& boxes_;
  std::vector<Bounds3f> of_instances_;
  double diagonal_ = 0;
};

}  // namespace tessera::bench
