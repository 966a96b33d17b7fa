// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/smooth_normals.h"

#include <cmath>

namespace tessera {

void smooth_normals(Mesh& mesh, std::span<const std::uint32_t> shared, std::uint32_t shared_count) {
  std::vector<Vec3f> sums(shared_count);
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = triangle[k];
      if (shared[vertex] == kNotSmoothed) continue;
      const Vec3f here = mesh.positions[vertex];
      const Vec3f ahead = normalize(mesh.positions[triangle[(k + 1) % 3]] - here);
      const Vec3f behind = normalize(mesh.positions[triangle[(k + 2) % 3]] - here);
      const Vec3f across = cross(ahead, behind);
      const Vec3f weighted = normalize(across) * std::atan2(length(across), dot(ahead, behind));
      if (is_finite(weighted)) sums[shared[vertex]] = sums[shared[vertex]] + weighted;
    }
  }
  for (std::size_t v = 0; v < shared.size(); ++v) {
    if (shared[v] != kNotSmoothed) mesh.normals[v] = normalize(sums[shared[v]]);
  }
}

}  // namespace tessera
