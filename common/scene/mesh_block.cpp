// SPDX-License-Identifier: Apache-2.0
#include "common/scene/mesh_block.h"

#include <algorithm>
#include <cstring>

#include "common/scene/block_bytes.h"
#include "common/scene/vertex_normals.h"

namespace tessera {
namespace {

// Calls f with the arrays of a mesh, constant or not, in the order of its block. Returns: what f
// returns.
template <class AnyMesh, class Array, class F>
auto with_arrays(AnyMesh& mesh, Array& normals, const F& f) {
  return f(normals, mesh.uvs, mesh.uvs1, mesh.tangents, mesh.colors, mesh.triangles, mesh.materials,
           mesh.positions);
}

// Whether the normals are those that the reader would make, zeros of either sign told apart.
bool do_normals_follow(const Mesh& mesh) {
  if (mesh.normals.empty()) return false;
  const std::vector<Vec3f> made = vertex_normals(mesh);
  return made.size() == mesh.normals.size() &&
         std::memcmp(made.data(), mesh.normals.data(), made.size() * sizeof(Vec3f)) == 0;
}

bool has_sound_triangles(const Mesh& mesh) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& triangle) {
    return *std::max_element(triangle.begin(), triangle.end()) < mesh.positions.size();
  });
}

bool skip_to_triangles(BlockReader& in) {
  if (!in.open(BlockKind::kMesh)) return false;
  in.get<std::uint32_t>();  // whether normals follow
  return in.skip_array(sizeof(Vec3f)) && in.skip_array(sizeof(Vec2f)) &&
         in.skip_array(sizeof(Vec2f)) && in.skip_array(sizeof(Vec4f)) &&
         in.skip_array(sizeof(Vec4f));
}

}  // namespace

std::vector<std::byte> encode_mesh(const Mesh& mesh) {
  const bool follows = do_normals_follow(mesh);
  const std::vector<Vec3f> none;
  BlockWriter out(BlockKind::kMesh);
  out.put(std::uint32_t{follows ? 1u : 0u});
  with_arrays(mesh, follows ? none : mesh.normals,
              [&](const auto&... arrays) { (out.put_array(arrays), ...); });
  return out.finish();
}

std::shared_ptr<const Mesh> decode_mesh(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  auto mesh = std::make_shared<Mesh>();
  if (!in.open(BlockKind::kMesh)) return nullptr;
  const auto follows = in.get<std::uint32_t>();
  const bool is_good = follows <= 1 && with_arrays(*mesh, mesh->normals, [&](auto&... arrays) {
                         return (in.get_array(arrays) && ...);
                       });
  if (!is_good || !in.is_finished()) return nullptr;
  if (follows == 0) return mesh;
  if (!mesh->normals.empty() || !has_sound_triangles(*mesh)) return nullptr;
  mesh->normals = vertex_normals(*mesh);
  return mesh;
}

std::uint64_t mesh_triangles(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  return skip_to_triangles(in) ? in.get_count(3 * sizeof(std::uint32_t)) : 0;
}

std::vector<std::uint32_t> mesh_materials(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  std::vector<std::uint32_t> materials;
  const bool is_good =
      skip_to_triangles(in) && in.skip_array(3 * sizeof(std::uint32_t)) && in.get_array(materials);
  return is_good ? materials : std::vector<std::uint32_t>{};
}

}  // namespace tessera
