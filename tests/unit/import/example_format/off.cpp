// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "master/import/read_file.h"

namespace tessera::import {

Result<ReadScene> read_off_file(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  std::size_t vertex_count = 0, face_count = 0, edge_count = 0;
  file >> word >> vertex_count >> face_count >> edge_count;
  auto mesh = std::make_shared<Mesh>();
  for (Vec3f p; mesh->positions.size() < vertex_count && file >> p.x >> p.y >> p.z;)
    mesh->positions.push_back(p);
  std::size_t corners = 0;
  for (std::array<std::uint32_t, 3> t{};
       mesh->triangles.size() < face_count && file >> corners >> t[0] >> t[1] >> t[2];)
    mesh->triangles.push_back(t);
  if (mesh->triangles.size() != face_count || corners != 3)
    return Status::data_loss(path + ": is cut short, or has faces that are no triangles");
  mesh->materials = {0};
  ReadScene read;
  read.scene.meshes = {mesh};
  read.scene.materials.emplace_back();
  read.scene.instances.emplace_back();
  return read;
}

}  // namespace tessera::import
