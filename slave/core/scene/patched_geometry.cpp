// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/patched_geometry.h"

#include <memory>
#include <utility>
#include <vector>

#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/placed/place_index.h"
#include "slave/core/primitive/placed/surface_places.h"
#include "slave/core/scene/flat_geometry.h"

namespace tessera::core {
namespace {

// The numbers of flattened triangles among the primitives of the scene.
std::vector<std::uint32_t> numbers_of(const TriangleSource& source, const TriangleStore& store) {
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    if (!source.is_stored(i)) continue;
    for (std::uint64_t n = store.instance_first[i]; n < store.instance_first[i + 1]; ++n)
      numbers.push_back(static_cast<std::uint32_t>(n));
  }
  return numbers;
}

// Sub-patches and places get the numbers of their instances.
std::shared_ptr<const PatchStore> numbered(PatchStore patches, const TriangleStore& triangles) {
  for (std::size_t i = 0; i + 1 < patches.first_part.size(); ++i) {
    auto number = static_cast<std::uint32_t>(triangles.instance_first[i]);
    for (std::uint64_t p = patches.first_part[i]; p < patches.first_part[i + 1]; ++p)
      patches.parts[p].primitive = number++;
  }
  for (std::size_t i = 0; i < patches.shared.of_instance.size(); ++i) {
    if (!patches.shared.has(i)) continue;
    patches.shared.places[patches.shared.of_instance[i]].first_primitive =
        static_cast<std::uint32_t>(triangles.instance_first[i]);
  }
  return std::make_shared<const PatchStore>(std::move(patches));
}

std::vector<std::uint64_t> first_numbers(const TriangleSource& source, const PatchStore& patches) {
  std::vector<std::uint64_t> first{0};
  for (std::size_t i = 0; i < source.instances.size(); ++i) {
    const std::uint64_t count =
        source.is_mesh(i) ? source.primitive_count(i) : patches.patch_count(i);
    first.push_back(first.back() + count);
  }
  return first;
}

// What the other version shares.
template <int W>
const PlacedBvh<W>* places_of(const Geometry* other) {
  return other == nullptr ? nullptr : std::get_if<PlacedBvh<W>>(&other->index.any);
}

template <int W>
Status build_index(const PatchedParts& parts, const Geometry* other, const BuildControl& control,
                   Geometry& geometry) {
  if (geometry.patches->shared.places.empty()) {
    auto index = index_patches<W>(parts, geometry.patches, control);
    if (!index.is_ok()) return index.status();
    geometry.index.any = std::move(*index);
    geometry.built_primitives = geometry.triangles.primitive_count();
    return Status::ok();
  }
  auto index = index_places<W>(parts, geometry.patches, places_of<W>(other), control);
  if (!index.is_ok()) return index.status();
  geometry.built_primitives = index->built_primitives;
  geometry.index.any = std::move(*index);
  return Status::ok();
}

}  // namespace

template <int W>
Status build_patched_geometry(const Scene& scene, const Geometry* other,
                              const BuildControl& control, Geometry& geometry) {
  std::vector<Bounds3f> part_boxes, boxes;
  const PatchSplitting splitting = splitting_of(scene);
  const SharedPlaces* const known =
      other == nullptr || other->patches == nullptr ? nullptr : &other->patches->shared;
  PatchStore patches = make_patch_store(
      scene, splitting, part_boxes, place_surfaces(scene, geometry.is_shareable, splitting, known));
  std::vector<std::uint64_t> part_counts;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    part_counts.push_back(patches.part_count(i));
  TriangleStore& store = geometry.triangles;
  const TriangleSource source{geometry.meshes(), geometry.instances, {}, part_counts};
  store = make_triangle_store(source, boxes);
  if (store.primitive_count() >= kNoPrimitive)
    return Status::resource_exhausted("the scene's patches have more than 2^32 - 1 parts");
  store.degenerate_count += patches.degenerate_count;
  const std::vector<std::uint32_t> numbers = numbers_of(source, store);
  leave_out(boxes, numbers, geometry);
  geometry.first_number = first_numbers(source, patches);
  geometry.patches = numbered(std::move(patches), store);
  return build_index<W>({boxes, store.vertices, numbers, part_boxes}, other, control, geometry);
}

template Status build_patched_geometry<8>(const Scene&, const Geometry*, const BuildControl&,
                                          Geometry&);
template Status build_patched_geometry<16>(const Scene&, const Geometry*, const BuildControl&,
                                           Geometry&);

}  // namespace tessera::core
