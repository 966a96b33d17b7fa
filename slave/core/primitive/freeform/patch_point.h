// SPDX-License-Identifier: Apache-2.0
// The point where a ray has met a patch.
//
// Where secondary rays start. P = S(u, v), evaluated in double and rounded to float32 by component,
// is off the surface by at most u |P_k|, u = 2^-24, by component k, and by errors of evaluation,
// which kEvaluationError bounds. Adding the offset rounds once more. Twice the sum of both, along
// the unit normal, leaves as much room again: for the surface's own bend within that distance,
// which is of second order, and for roundings of the normal. So a ray that goes on on its side of
// the surface does not meet the root that it starts on, and misses nothing that is farther than
// some roundings of P away.
//
// The normal is along dS/du x dS/dv. Where that vanishes, as on collapsed borders, it is that of a
// place nearer to the middle of the patch, by the least of 2^-20, 2^-19, ... at which there is one.
//
// Threads. Each thread has memory of its own for the complete solver.
#pragma once

#include "common/frame/patch_method.h"
#include "common/scene/scene.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

struct PatchSurfacePoint {
  Vec3f point;
  Vec3f normal;        // unit, along dS/du x dS/dv
  float offset = 0;    // along the normal, at least this far
  float u = 0, v = 0;  // the patch's own
};

// Hits of a method of the frame's may be off the surface (method_error()): rays then start farther
// away by twice that, so that they do not meet what stands for the surface there.
//
// Requires: the ray meets the sub-patch at t, as answer_by() says. Shape: origin, direction [3].
PatchSurfacePoint patch_point(const Patch& patch, const SubPatch& part, const float* origin,
                              const float* direction, float t,
                              PatchMethod method = PatchMethod::kAuto);

// The plane that touches the patch at (u, v), as the triangle on which (u, v) are the patch's.
struct TangentTriangle {
  Vec3f corner[3];  // at (0, 0), (1, 0), (0, 1)
};
TangentTriangle tangent_triangle(const Patch& patch, float u, float v);

// What stands for the mesh of patches where attributes of meshes are looked up: one triangle with
// the coordinates of a TangentTriangle.
const Mesh& mesh_of_patches();

}  // namespace tessera::core
