// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/instanced_index.h"

#include <numeric>
#include <unordered_map>
#include <utility>

#include "slave/core/primitive/instance/exact_bounds.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/instance/instance_writer.h"

namespace tessera::core {
namespace {

bool is_lamp(const Mesh& mesh, const Scene& scene) {
  for (const std::uint32_t material : mesh.materials) {
    if (scene.materials[material].emission != Vec3f{}) return true;
  }
  return false;
}

// Returns: for each mesh, whether it gets a structure of its own.
std::vector<bool> shared_meshes(const Scene& scene, Instancing instancing) {
  std::vector<std::uint64_t> count(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++count[instance.mesh];
  std::vector<bool> is_shared(scene.meshes.size(), false);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const std::uint64_t triangles = scene.meshes[m]->triangles.size();
    if (count[m] == 0 || triangles == 0 || instancing == Instancing::kNever) continue;
    const bool pays = (count[m] - 1) * triangles >= kSharedTrianglesMin;
    if (!pays && instancing != Instancing::kAlways) continue;
    is_shared[m] = !is_lamp(*scene.meshes[m], scene);
  }
  return is_shared;
}

// Finds instances that stand in the other version of the scene at the same number.
template <int W>
class KnownPlaces {
 public:
  explicit KnownPlaces(const KnownInstances<W>& known) : known_(known) {}

  // Requires: is called for each instance of the scene, in order. Returns: the number among the
  // other version's placed instances of one that is the same, or -1.
  std::int64_t next(const Mesh* mesh, const Instance& instance) {
    if (known_.index == nullptr || at_ >= known_.instances.size()) return -1;
    const Instance& other = known_.instances[at_];
    const bool is_placed = known_.index->is_placed[at_++] != 0;
    if (!is_placed) return -1;
    const std::int64_t number = placed_++;
    const bool is_same = known_.meshes[other.mesh].get() == mesh &&
                         other.object_to_world == instance.object_to_world;
    return is_same ? number : -1;
  }

 private:
  const KnownInstances<W>& known_;
  std::size_t at_ = 0;
  std::int64_t placed_ = 0;
};

template <int W>
Status index_meshes(const Scene& scene, const std::vector<bool>& is_shared,
                    const KnownInstances<W>& known, const BuildControl& control,
                    Placement<W>& placement) {
  std::unordered_map<const Mesh*, std::shared_ptr<const MeshIndex<W>>> have;
  for (std::size_t m = 0; known.index != nullptr && m < known.meshes.size(); ++m) {
    if (known.index->meshes[m]) have[known.meshes[m].get()] = known.index->meshes[m];
  }
  placement.meshes.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (!is_shared[m]) continue;
    std::shared_ptr<const MeshIndex<W>>& index = have[scene.meshes[m].get()];
    if (!index) {
      Result<std::shared_ptr<const MeshIndex<W>>> built = index_mesh<W>(*scene.meshes[m], control);
      if (!built.is_ok()) return built.status();
      index = std::move(*built);
    }
    placement.meshes[m] = index;
  }
  return Status::ok();
}

}  // namespace

template <int W>
std::uint64_t InstancedBvh<W>::memory_bytes() const {
  std::uint64_t bytes = structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t) +
                        triangles.capacity() * sizeof(TriangleBlock<W>) +
                        instances.capacity() * sizeof(InstanceBlock) +
                        boxes.capacity() * sizeof(Bounds3f) + is_placed.capacity();
  for (const auto& mesh : meshes) {
    if (mesh) bytes += mesh->bvh.memory_bytes() + mesh->parts.capacity() * sizeof(Bounds3f);
  }
  return bytes + meshes.capacity() * (sizeof(meshes[0]) + sizeof(shapes[0]));
}
template std::uint64_t InstancedBvh<8>::memory_bytes() const;
template std::uint64_t InstancedBvh<16>::memory_bytes() const;

template <int W>
Result<Placement<W>> place_instances(const Scene& scene, Instancing instancing,
                                     const KnownInstances<W>& known, const BuildControl& control) {
  Placement<W> placement;
  const std::vector<bool> is_shared = shared_meshes(scene, instancing);
  TESSERA_RETURN_IF_ERROR(index_meshes(scene, is_shared, known, control, placement));
  placement.is_placed.assign(scene.instances.size(), 0);
  KnownPlaces<W> places(known);
  std::uint64_t first = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh* const mesh = scene.meshes[instance.mesh].get();
    const std::uint64_t number = std::exchange(first, first + mesh->triangles.size());
    const std::int64_t same = places.next(mesh, instance);
    const MeshIndex<W>* const index = placement.meshes[instance.mesh].get();
    if (index == nullptr) continue;
    InstanceBlock block;
    Bounds3f box;
    if (same >= 0) {
      block = known.index->instances[static_cast<std::size_t>(same)];
      box = known.index->boxes[static_cast<std::size_t>(same)];
    } else {
      const auto placed = place_instance(instance.object_to_world, index->bvh.structure.bounds);
      if (!placed) continue;
      block = *placed;
      box = placed_bounds(instance.object_to_world, index->parts);
    }
    block.mesh = instance.mesh;
    block.first_primitive = static_cast<std::uint32_t>(number);
    placement.is_placed[i] = 1;
    placement.instances.push_back(block);
    placement.boxes.push_back(box);
    placement.degenerate_count += index->degenerate_count;
  }
  return placement;
}

template <int W>
Result<InstancedBvh<W>> index_instances(Placement<W> placement, std::span<const Bounds3f> boxes,
                                        std::span<const float> vertices,
                                        std::span<const std::uint32_t> numbers,
                                        const BuildControl& control) {
  std::vector<Bounds3f> all(boxes.begin(), boxes.end());
  all.insert(all.end(), placement.boxes.begin(), placement.boxes.end());
  std::vector<std::uint32_t> items(placement.instances.size());
  std::iota(items.begin(), items.end(), static_cast<std::uint32_t>(boxes.size()));
  InstanceWriter<W> writer(vertices, items);
  const PrimitiveSet set{all, writer, static_cast<std::uint32_t>(boxes.size())};
  Result<Bvh<W>> bvh = build_bvh<W>(set, control);
  if (!bvh.is_ok()) return bvh.status();
  InstancedBvh<W> index;
  index.structure = std::move(*bvh);
  index.blocks = writer.take_blocks();
  index.triangles = writer.take_triangles();
  for (TriangleBlock<W>& block : index.triangles) {
    for (std::uint32_t& primitive : block.primitive) {
      if (primitive < numbers.size()) primitive = numbers[primitive];
    }
  }
  index.instances = std::move(placement.instances);
  index.boxes = std::move(placement.boxes);
  index.is_placed = std::move(placement.is_placed);
  index.meshes = std::move(placement.meshes);
  for (const auto& mesh : index.meshes)
    index.shapes.push_back(mesh ? mesh->shape() : MeshShape<W>{});
  Bounds3f flattened;
  for (const Bounds3f& box : boxes) flattened.grow(box);
  index.bounds = exact_bounds(index, flattened);
  return index;
}

template Result<Placement<8>> place_instances<8>(const Scene&, Instancing, const KnownInstances<8>&,
                                                 const BuildControl&);
template Result<Placement<16>> place_instances<16>(const Scene&, Instancing,
                                                   const KnownInstances<16>&, const BuildControl&);
template Result<InstancedBvh<8>> index_instances<8>(Placement<8>, std::span<const Bounds3f>,
                                                    std::span<const float>,
                                                    std::span<const std::uint32_t>,
                                                    const BuildControl&);
template Result<InstancedBvh<16>> index_instances<16>(Placement<16>, std::span<const Bounds3f>,
                                                      std::span<const float>,
                                                      std::span<const std::uint32_t>,
                                                      const BuildControl&);

}  // namespace tessera::core
