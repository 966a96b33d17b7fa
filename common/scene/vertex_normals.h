// SPDX-License-Identifier: Apache-2.0
// Normals that follow from a mesh's positions: at each vertex the sum of the normals of its
// triangles, each as long as the triangle is large (H. Gouraud, "Continuous Shading of Curved
// Surfaces", 1971, weighted by area). Additions, products, quotients and square roots alone, in one
// order, so that every processor makes the same bits: a mesh that has these normals travels without
// them, and the receiver makes them anew.
//
// Threads. Pure function.
#pragma once

#include <vector>

#include "common/base/api.h"
#include "common/scene/scene.h"

namespace tessera {

// Returns: [vertex_count], of length 1; zero, which means flat shading, where triangles cancel each
// other out, have no area, or are too large for their products to be finite.
// Requires: the triangles' indices are below the number of positions.
TESSERA_API std::vector<Vec3f> vertex_normals(const Mesh& mesh);

}  // namespace tessera
