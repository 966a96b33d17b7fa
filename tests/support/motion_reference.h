// SPDX-License-Identifier: Apache-2.0
// Another evaluator of animations, for comparison with ScenePoser: in double, by the sines and 4x4
// matrices of the specification's text (glTF 2.0, section 3.11 and appendix C), node by node and
// vertex by vertex, without anything shared.
// Threads. Pure functions.
#pragma once

#include <array>
#include <vector>

#include "common/scene/scene.h"

namespace tessera::test {

using Matrix4 = std::array<std::array<double, 4>, 4>;

// The place of a node in world space, by the first clip.
Matrix4 reference_place(const SceneAnimation& animation, std::uint32_t node, double seconds);

// The vertices of a deformed mesh, of number `deformed` among SceneAnimation::meshes.
std::vector<std::array<double, 3>> reference_vertices(const Scene& scene, std::size_t deformed,
                                                      double seconds);

}  // namespace tessera::test
