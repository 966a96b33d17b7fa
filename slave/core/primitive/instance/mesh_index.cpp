// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/mesh_index.h"

#include <utility>

#include "slave/core/accel/bvh_children.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::core {

template <int W>
MeshShape<W> MeshIndex<W>::shape() const {
  return {bvh.structure.nodes.data(), bvh.triangles.data(),
          static_cast<std::uint32_t>(bvh.triangles.size()), scene_box(bvh.structure.bounds)};
}

template <int W>
MeshIndex<W> mesh_index_of(IndexedBvh<W> bvh) {
  MeshIndex<W> index;
  index.bvh = std::move(bvh);
  index.bvh.triangles.shrink_to_fit();
  if (index.bvh.structure.nodes.empty()) return index;
  const BvhNode<W>& root = index.bvh.structure.nodes[0];
  for (int i = 0; i < W; ++i) {
    if (root.child[i] != kBvhNoChild) index.parts.push_back(child_box(root, i));
  }
  return index;
}

template <int W>
Result<std::shared_ptr<const MeshIndex<W>>> index_mesh(const Mesh& mesh,
                                                       const BuildControl& control) {
  std::vector<float> vertices;
  std::vector<Bounds3f> boxes;
  vertices.reserve(mesh.triangles.size() * 9);
  boxes.reserve(mesh.triangles.size());
  std::uint64_t degenerate_count = 0;
  for (const auto& triangle : mesh.triangles) {
    Vec3f p[3];
    Bounds3f box;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.positions[triangle[k]];
      vertices.insert(vertices.end(), {p[k].x, p[k].y, p[k].z});
      box.grow(p[k]);
    }
    if (is_degenerate(p[0], p[1], p[2])) ++degenerate_count;
    boxes.push_back(is_in_mesh_index(p[0], p[1], p[2]) ? box : Bounds3f{});
  }
  Result<IndexedBvh<W>> bvh = index_by_bvh<W>(boxes, vertices, control);
  if (!bvh.is_ok()) return bvh.status();
  auto index = std::make_shared<MeshIndex<W>>(mesh_index_of<W>(std::move(*bvh)));
  index->degenerate_count = degenerate_count;
  return std::shared_ptr<const MeshIndex<W>>(std::move(index));
}

template struct MeshIndex<8>;
template struct MeshIndex<16>;
template MeshIndex<8> mesh_index_of<8>(IndexedBvh<8>);
template MeshIndex<16> mesh_index_of<16>(IndexedBvh<16>);
template Result<std::shared_ptr<const MeshIndex<8>>> index_mesh<8>(const Mesh&,
                                                                   const BuildControl&);
template Result<std::shared_ptr<const MeshIndex<16>>> index_mesh<16>(const Mesh&,
                                                                     const BuildControl&);

}  // namespace tessera::core
