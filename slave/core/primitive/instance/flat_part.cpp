// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/flat_part.h"

#include <utility>

namespace tessera::core {

template <int W>
std::vector<std::uint32_t> FlatPart<W>::numbers() const {
  std::vector<std::uint32_t> numbers;
  for (const FlatInstance& instance : made_of) {
    for (std::size_t i = 0; i < instance.mesh->triangles.size(); ++i)
      numbers.push_back(static_cast<std::uint32_t>(instance.first + i));
  }
  return numbers;
}

template <int W>
FlatPart<W> flat_part_of(const Scene& scene, std::span<const std::uint8_t> is_placed) {
  FlatPart<W> part;
  std::uint64_t first = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const std::shared_ptr<const Mesh>& mesh = scene.meshes[instance.mesh];
    if (is_placed[i] == 0) part.made_of.push_back({mesh, instance.object_to_world, first});
    first += mesh->triangles.size();
  }
  return part;
}

template <int W>
Status index_flat_part(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                       const BuildControl& control, FlatPart<W>& part) {
  Result<IndexedBvh<W>> bvh = index_by_bvh<W>(boxes, vertices, control);
  if (!bvh.is_ok()) return bvh.status();
  const std::vector<std::uint32_t> numbers = part.numbers();
  for (TriangleBlock<W>& block : bvh->triangles) {
    for (std::uint32_t& primitive : block.primitive) {
      if (primitive < numbers.size()) primitive = numbers[primitive];
    }
  }
  part.index = std::make_shared<const MeshIndex<W>>(mesh_index_of<W>(std::move(*bvh)));
  return Status::ok();
}

template struct FlatPart<8>;
template struct FlatPart<16>;
template FlatPart<8> flat_part_of<8>(const Scene&, std::span<const std::uint8_t>);
template FlatPart<16> flat_part_of<16>(const Scene&, std::span<const std::uint8_t>);
template Status index_flat_part<8>(std::span<const Bounds3f>, std::span<const float>,
                                   const BuildControl&, FlatPart<8>&);
template Status index_flat_part<16>(std::span<const Bounds3f>, std::span<const float>,
                                    const BuildControl&, FlatPart<16>&);

}  // namespace tessera::core
