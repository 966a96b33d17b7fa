// SPDX-License-Identifier: Apache-2.0
// Normals of vertices for files that say which triangles are smooth together, and no normals: the
// mean of the triangles' normals, weighted by the angle of the corner (G. Thuermer, C. Wuethrich,
// "Computing vertex normals from polygonal facets", 1998).
// Threads. Pure function.
#pragma once

#include <cstdint>
#include <span>

#include "common/scene/scene.h"

namespace tessera {

inline constexpr std::uint32_t kNotSmoothed = 0xffffffffu;

// Vertices of one number in `shared` [vertex_count] get one normal; those of kNotSmoothed keep
// theirs. Where the triangles cancel each other out, or have no area, the normal is zero, which
// means flat shading.
// Requires: mesh.normals is [vertex_count]; numbers are below `shared_count`.
void smooth_normals(Mesh& mesh, std::span<const std::uint32_t> shared, std::uint32_t shared_count);

}  // namespace tessera
