// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/instanced_index.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "common/base/check.h"
#include "slave/core/primitive/instance/exact_bounds.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/instance/top_edit.h"
#include "slave/core/primitive/mixed_writer.h"

namespace tessera::core {
namespace {

// Finds instances that stand in the other version of the scene at the same number.
template <int W>
class KnownPlaces {
 public:
  explicit KnownPlaces(const KnownInstances<W>& known) : known_(known) {}

  // Requires: is called for each instance of the scene, in order. Returns: the number among the
  // other version's placed instances of one that is the same, or -1.
  std::int64_t next(const Mesh* mesh, const Instance& instance) {
    if (known_.index == nullptr || at_ >= known_.scene.instances.size()) return -1;
    const std::size_t at = at_++;
    if (known_.index->is_placed[at] == 0) return -1;
    const std::int64_t number = placed_++;
    return is_same(at, mesh, instance) ? number : -1;
  }

 private:
  bool is_same(std::size_t at, const Mesh* mesh, const Instance& instance) {
    if (const auto& moved = known_.scene.change.moved) {
      while (moved_ < moved->size() && (*moved)[moved_] < at) ++moved_;
      return moved_ == moved->size() || (*moved)[moved_] != at;
    }
    const Instance& other = known_.scene.instances[at];
    return known_.scene.meshes[other.mesh].get() == mesh &&
           other.object_to_world == instance.object_to_world;
  }

  const KnownInstances<W>& known_;
  std::size_t at_ = 0, moved_ = 0;
  std::int64_t placed_ = 0;
};

template <int W>
using MeshIndices = std::unordered_map<const Mesh*, std::shared_ptr<const MeshIndex<W>>>;

template <int W>
MeshIndices<W> indices_of(const KnownInstances<W>& known) {
  MeshIndices<W> indices;
  for (std::size_t m = 0; known.index != nullptr && m < known.scene.meshes.size(); ++m) {
    if (known.index->meshes[m]) indices[known.scene.meshes[m].get()] = known.index->meshes[m];
  }
  return indices;
}

// Returns: what the other version has built of the mesh of this number, where it is the same there.
template <int W>
std::shared_ptr<const MeshIndex<W>> index_at_place(const Scene& scene, std::size_t m,
                                                   const KnownInstances<W>& known) {
  const bool is_same = known.index != nullptr && m < known.scene.meshes.size() &&
                       known.scene.meshes[m] == scene.meshes[m];
  return is_same ? known.index->meshes[m] : nullptr;
}

// The same of what is built when a ray meets it. Requires: index_at_place() has nothing.
template <int W>
std::shared_ptr<MeshSlot<W>> slot_at_place(const Scene& scene, std::size_t m,
                                           const KnownInstances<W>& known) {
  if (known.index == nullptr || m >= known.scene.meshes.size()) return nullptr;
  const std::shared_ptr<MeshSlot<W>>& slot = known.index->slots[m];
  return slot && &slot->mesh() == scene.meshes[m].get() && !slot->has_failed() ? slot : nullptr;
}

template <int W>
std::unordered_map<const Mesh*, std::shared_ptr<MeshSlot<W>>> slots_of(
    const KnownInstances<W>& known) {
  std::unordered_map<const Mesh*, std::shared_ptr<MeshSlot<W>>> slots;
  if (known.index == nullptr) return slots;
  for (const auto& slot : known.index->slots) {
    if (slot && !slot->has_failed()) slots[&slot->mesh()] = slot;
  }
  return slots;
}

// Makes slots for the meshes that no other version has built.
template <int W>
void make_slots(const Scene& scene, const std::vector<bool>& is_shared,
                const KnownInstances<W>& known, Placement<W>& placement) {
  // Made where a mesh is not at the place that it had.
  std::optional<MeshIndices<W>> have;
  std::unordered_map<const Mesh*, std::shared_ptr<MeshSlot<W>>> slots;
  placement.meshes.resize(scene.meshes.size());
  placement.slots.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (!is_shared[m]) continue;
    placement.meshes[m] = index_at_place(scene, m, known);
    placement.slots[m] = slot_at_place(scene, m, known);
    if (placement.meshes[m] || placement.slots[m]) continue;
    if (!have) {
      have = indices_of(known);
      slots = slots_of(known);
    }
    const auto built = have->find(scene.meshes[m].get());
    if (built != have->end()) {
      placement.meshes[m] = built->second;
      continue;
    }
    std::shared_ptr<MeshSlot<W>>& slot = slots[scene.meshes[m].get()];
    if (!slot) slot = std::make_shared<MeshSlot<W>>(scene.meshes[m]);
    placement.slots[m] = slot;
  }
}

template <int W>
Status index_meshes(const Scene& scene, const std::vector<bool>& is_shared,
                    const KnownInstances<W>& known, const BuildControl& control,
                    Placement<W>& placement) {
  std::optional<MeshIndices<W>> have;  // made where a mesh is not at the place that it had
  placement.meshes.resize(scene.meshes.size());
  placement.slots.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (!is_shared[m]) continue;
    placement.meshes[m] = index_at_place(scene, m, known);
    if (placement.meshes[m]) continue;
    if (!have) have = indices_of(known);
    std::shared_ptr<const MeshIndex<W>>& index = (*have)[scene.meshes[m].get()];
    if (!index) {
      Result<std::shared_ptr<const MeshIndex<W>>> built = index_mesh<W>(*scene.meshes[m], control);
      if (!built.is_ok()) return built.status();
      index = std::move(*built);
      placement.built_primitives += scene.meshes[m]->triangles.size();
    }
    placement.meshes[m] = index;
  }
  return Status::ok();
}

// Puts what is flattened behind the instances, as one of them.
template <int W>
void place_flat_part(const MeshIndex<W>& part, Placement<W>& placement) {
  auto block = place_instance(Transform{}, part.bvh.structure.bounds);
  TESSERA_CHECK(block.has_value());
  block->mesh = static_cast<std::uint32_t>(placement.meshes.size());
  block->first_primitive = 0;  // its triangles have their numbers over the scene
  placement.instances.push_back(*block);
  placement.boxes.push_back(placed_bounds(Transform{}, part.parts));
}

// Builds the hierarchy over flattened triangles, in front, and over instances.
template <int W>
Status build_top(const Flattened<W>& flattened, const BuildControl& control,
                 InstancedBvh<W>& index) {
  const bool is_apart = flattened.part->index != nullptr;
  std::vector<Bounds3f> all;
  if (!is_apart) all.assign(flattened.boxes.begin(), flattened.boxes.end());
  const auto triangles = static_cast<std::uint32_t>(all.size());
  all.insert(all.end(), index.boxes.begin(), index.boxes.end());
  std::vector<std::uint32_t> items(index.instances.size());
  std::iota(items.begin(), items.end(), triangles);
  MixedWriter<W> writer(is_apart ? std::span<const float>() : flattened.vertices, items);
  const PrimitiveSet set{all, writer, triangles};
  Result<Bvh<W>> bvh = build_bvh<W>(set, control);
  if (!bvh.is_ok()) return bvh.status();
  index.structure = std::move(*bvh);
  index.blocks = writer.take_blocks();
  index.triangles = writer.take_triangles();
  index.built_primitives += all.size();
  if (is_apart) return Status::ok();
  const std::vector<std::uint32_t> numbers = flattened.part->numbers();
  for (TriangleBlock<W>& block : index.triangles) {
    for (std::uint32_t& primitive : block.primitive) {
      if (primitive < numbers.size()) primitive = numbers[primitive];
    }
  }
  return Status::ok();
}

// Instances whose place or mesh is another one than in the other version, which has as many, or all
// but what is flattened.
template <int W>
std::vector<std::uint32_t> changed_instances(const InstancedBvh<W>& index,
                                             const InstancedBvh<W>& known) {
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = 0; i < known.instances.size(); ++i) {
    const InstanceBlock &now = index.instances[i], &then = known.instances[i];
    const bool is_same = std::memcmp(now.to_world, then.to_world, sizeof now.to_world) == 0 &&
                         index.shapes[now.mesh].nodes == known.shapes[then.mesh].nodes &&
                         index.shapes[now.mesh].triangles == known.shapes[then.mesh].triangles;
    if (!is_same) changed.push_back(i);
  }
  return changed;
}

// Whether the other version has the same triangles flattened, in the hierarchy over all, and as
// many instances; here they are behind these as one of them.
template <int W>
bool has_parted(const FlatPart<W>& part, const InstancedBvh<W>& known, std::size_t instances) {
  return part.index && !known.triangles.empty() && known.instances.size() + 1 == instances &&
         known.flat->made_of == part.made_of;
}

// Hierarchies that were edited so often become worse than those that were built as a whole; a
// quarter of the instances is far from where that can be measured (decisions/instances.md).
bool is_edited_too_often(std::uint64_t moves, std::size_t instance_count) {
  return moves > std::max<std::uint64_t>(instance_count / 4, 1);
}

// Returns: false where the hierarchy has to be built as a whole.
template <int W>
bool edit_top(const InstancedBvh<W>& known, std::span<const std::uint32_t> changed,
              InstancedBvh<W>& index) {
  index.moves = known.moves + changed.size();
  if (is_edited_too_often(index.moves, index.instances.size())) return false;
  TopEdit<W> edit(known.structure, known.blocks, index.boxes);
  for (const std::uint32_t instance : changed) {
    if (!edit.move(instance)) return false;
  }
  index.structure = edit.take_top();
  index.blocks = edit.take_blocks();
  index.built_primitives += changed.size();
  return true;
}

}  // namespace

template <int W>
std::uint64_t InstancedBvh<W>::memory_bytes() const {
  std::uint64_t bytes = structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t) +
                        triangles.capacity() * sizeof(TriangleBlock<W>) +
                        instances.capacity() * sizeof(InstanceBlock) +
                        boxes.capacity() * sizeof(Bounds3f) + is_placed.capacity();
  const auto add = [&](const MeshIndex<W>* mesh) {
    if (mesh != nullptr)
      bytes += mesh->bvh.memory_bytes() + mesh->parts.capacity() * sizeof(Bounds3f);
  };
  for (const auto& mesh : meshes) add(mesh.get());
  for (const auto& slot : slots) add(slot ? slot->built() : nullptr);
  add(flat->index.get());
  bytes += flat->made_of.capacity() * sizeof(FlatInstance);
  return bytes + meshes.capacity() * (sizeof(meshes[0]) + sizeof(shapes[0]));
}
template <int W>
std::uint64_t InstancedBvh<W>::met_primitives() const {
  std::uint64_t count = 0;
  for (const auto& slot : slots) {
    if (slot && slot->built() != nullptr) count += slot->mesh().triangles.size();
  }
  return count;
}
template std::uint64_t InstancedBvh<8>::memory_bytes() const;
template std::uint64_t InstancedBvh<16>::memory_bytes() const;
template std::uint64_t InstancedBvh<8>::met_primitives() const;
template std::uint64_t InstancedBvh<16>::met_primitives() const;

template <int W>
Result<Placement<W>> place_instances(const Scene& scene, const PlacementOptions& options,
                                     const KnownInstances<W>& known, const BuildControl& control) {
  Placement<W> placement;
  placement.is_moving = moving_meshes(scene, known.scene);
  const std::vector<bool> is_shared = shared_meshes(
      scene, options.is_on_demand ? Instancing::kAlways : options.instancing, placement.is_moving);
  if (options.is_on_demand) {
    make_slots(scene, is_shared, known, placement);
  } else {
    TESSERA_RETURN_IF_ERROR(index_meshes(scene, is_shared, known, control, placement));
  }
  placement.is_placed.assign(scene.instances.size(), 0);
  KnownPlaces<W> places(known);
  std::uint64_t first = 0;  // unused where only places differ: numbers are the same then
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh* const mesh = scene.meshes[instance.mesh].get();
    const std::uint64_t number = known.scene.change.moved
                                     ? known.first_numbers[i]
                                     : std::exchange(first, first + mesh->triangles.size());
    const std::int64_t same = places.next(mesh, instance);
    const MeshIndex<W>* const index = placement.meshes[instance.mesh].get();
    const MeshSlot<W>* const slot = placement.slots[instance.mesh].get();
    if (index == nullptr && slot == nullptr) continue;
    InstanceBlock block;
    Bounds3f box;
    if (same >= 0) {
      block = known.index->instances[static_cast<std::size_t>(same)];
      box = known.index->boxes[static_cast<std::size_t>(same)];
    } else {
      const Bounds3f& bounds = slot != nullptr ? slot->bounds() : index->bvh.structure.bounds;
      const auto placed = place_instance(instance.object_to_world, bounds);
      if (!placed) continue;
      block = *placed;
      box = placed_bounds(instance.object_to_world,
                          slot != nullptr ? std::span(&bounds, 1) : std::span(index->parts));
    }
    block.mesh = instance.mesh;
    block.first_primitive = static_cast<std::uint32_t>(number);
    placement.is_placed[i] = 1;
    placement.instances.push_back(block);
    placement.boxes.push_back(box);
    placement.degenerate_count +=
        slot != nullptr ? slot->degenerate_count() : index->degenerate_count;
  }
  return placement;
}

template <int W>
bool has_same_flat_part(const Placement<W>& placement, const KnownInstances<W>& known) {
  const auto& moved = known.scene.change.moved;
  if (known.index == nullptr || !moved || known.index->is_placed != placement.is_placed)
    return false;
  return std::all_of(moved->begin(), moved->end(),
                     [&](std::uint32_t i) { return placement.is_placed[i] != 0; });
}

template <int W>
Result<InstancedBvh<W>> index_instances(Placement<W> placement, Flattened<W> flattened,
                                        const InstancedBvh<W>* known, const BuildControl& control) {
  if (!flattened.part) flattened.part = std::make_shared<const FlatPart<W>>();
  const MeshIndex<W>* const apart = flattened.part->index.get();
  if (apart != nullptr) place_flat_part(*apart, placement);
  InstancedBvh<W> index;
  index.instances = std::move(placement.instances);
  index.boxes = std::move(placement.boxes);
  index.is_placed = std::move(placement.is_placed);
  index.meshes = std::move(placement.meshes);
  index.slots = std::move(placement.slots);
  index.is_moving = std::move(placement.is_moving);
  index.built_primitives = placement.built_primitives;
  index.shapes.reserve(index.meshes.size() + 1);
  for (std::size_t m = 0; m < index.meshes.size(); ++m) {
    index.shapes.push_back(index.meshes[m] ? index.meshes[m]->shape() : MeshShape<W>{});
    if (index.slots[m]) index.shapes.back() = index.slots[m]->shape();
  }
  if (apart != nullptr) index.shapes.push_back(apart->shape());

  const bool is_all_placed = apart != nullptr || flattened.vertices.empty();
  const bool is_comparable = is_all_placed && known != nullptr && known->triangles.empty() &&
                             known->instances.size() == index.instances.size();
  const bool is_bounded = is_comparable || (known != nullptr && has_parted(*flattened.part, *known,
                                                                           index.instances.size()));
  std::vector<std::uint32_t> changed;
  if (is_bounded) changed = changed_instances(index, *known);
  if (!is_comparable || !edit_top(*known, changed, index)) {
    index.moves = 0;
    TESSERA_RETURN_IF_ERROR(build_top(flattened, control, index));
  }
  Bounds3f of_flattened;
  for (const Bounds3f& box : flattened.boxes) {
    if (apart == nullptr) of_flattened.grow(box);
  }
  set_exact_bounds(of_flattened, is_bounded ? known : nullptr, changed, index);
  index.flat = std::move(flattened.part);
  return index;
}

template bool has_same_flat_part<8>(const Placement<8>&, const KnownInstances<8>&);
template bool has_same_flat_part<16>(const Placement<16>&, const KnownInstances<16>&);
template Result<Placement<8>> place_instances<8>(const Scene&, const PlacementOptions&,
                                                 const KnownInstances<8>&, const BuildControl&);
template Result<Placement<16>> place_instances<16>(const Scene&, const PlacementOptions&,
                                                   const KnownInstances<16>&, const BuildControl&);
template Result<InstancedBvh<8>> index_instances<8>(Placement<8>, Flattened<8>,
                                                    const InstancedBvh<8>*, const BuildControl&);
template Result<InstancedBvh<16>> index_instances<16>(Placement<16>, Flattened<16>,
                                                      const InstancedBvh<16>*, const BuildControl&);

}  // namespace tessera::core
