// SPDX-License-Identifier: Apache-2.0
#include "common/scene/vertex_normals.h"

#include "common/base/work_gate.h"

namespace tessera {

std::vector<Vec3f> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3f> normals(mesh.positions.size());
  SmallSteps steps;
  for (const auto& [a, b, c] : mesh.triangles) {
    steps.next();
    const Vec3f p = mesh.positions[a];
    const Vec3f weighted = cross(mesh.positions[b] - p, mesh.positions[c] - p);
    for (const std::uint32_t vertex : {a, b, c}) normals[vertex] = normals[vertex] + weighted;
  }
  for (Vec3f& normal : normals) {
    steps.next();
    normal = normalize(normal);
    if (!is_finite(normal)) normal = {};
  }
  return normals;
}

}  // namespace tessera
