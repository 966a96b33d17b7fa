// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate_mesh.h"

#include "common/scene/validate_material.h"

namespace tessera {
namespace {

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

// Checks an array that either all vertices have or none.
template <typename T>
Status validate_array(const std::vector<T>& values, const std::string& name, const char* what,
                      std::size_t vertex_count) {
  if (values.empty()) return Status::ok();
  if (values.size() != vertex_count) {
    return Status::invalid_argument(name + ": " + what + "s and vertices differ in number");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_finite(values[i]))
      return Status::invalid_argument(name + ", " + numbered(what, i) + " is not finite");
  }
  return Status::ok();
}

}  // namespace

Status validate_mesh(const Mesh& mesh, const std::string& name, std::size_t material_count) {
  const std::size_t vertex_count = mesh.positions.size();
  if (vertex_count > 0xffffffffu)
    return Status::resource_exhausted(name + ": more than 2^32 - 1 vertices");
  for (std::size_t i = 0; i < vertex_count; ++i) {
    if (!is_finite(mesh.positions[i]))
      return Status::invalid_argument(name + ", " + numbered("vertex", i) + " is not finite");
  }
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.normals, name, "normal", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.uvs, name, "texture coordinate", vertex_count));
  TESSERA_RETURN_IF_ERROR(
      validate_array(mesh.uvs1, name, "second texture coordinate", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.tangents, name, "tangent", vertex_count));
  TESSERA_RETURN_IF_ERROR(validate_array(mesh.colors, name, "colour", vertex_count));
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const Vec4f& c = mesh.colors[i];
    if (!is_share(c.x) || !is_share(c.y) || !is_share(c.z) || !is_share(c.w)) {
      return Status::invalid_argument(name + ", " + numbered("colour", i) + " must lie in [0, 1]");
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t vertex : mesh.triangles[i]) {
      if (vertex >= vertex_count) {
        return Status::invalid_argument(name + ", " + numbered("triangle", i) + ": vertex " +
                                        std::to_string(vertex) + " of " +
                                        std::to_string(vertex_count));
      }
    }
  }
  if (mesh.materials.size() != 1 && mesh.materials.size() != mesh.triangles.size()) {
    return Status::invalid_argument(name + ": needs one material, or one for each triangle");
  }
  for (const std::uint32_t material : mesh.materials) {
    if (material >= material_count) {
      return Status::invalid_argument(name + ": material " + std::to_string(material) + " of " +
                                      std::to_string(material_count));
    }
  }
  return Status::ok();
}

}  // namespace tessera
