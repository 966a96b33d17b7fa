// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/placed/place_index.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "slave/core/accel/bvh_children.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "slave/core/primitive/mixed_writer.h"
#include "slave/core/primitive/placed/exact_place_bounds.h"
#include "slave/core/primitive/placed/surface_index.h"

namespace tessera::core {
namespace {

template <int W>
Status index_surfaces(const PlacedBvh<W>* known, const BuildControl& control, PlacedBvh<W>& index) {
  std::unordered_map<const SharedSurface*, std::shared_ptr<const SurfaceIndex<W>>> have;
  if (known != nullptr) {
    for (const auto& surface : known->surfaces) {
      if (surface) have[surface->surface.get()] = surface;
    }
  }
  for (const auto& surface : index.patches->shared.surfaces) {
    index.surfaces.emplace_back();
    index.shapes.push_back({});
    if (!surface) continue;
    std::shared_ptr<const SurfaceIndex<W>>& built = have[surface.get()];
    if (!built) {
      auto fresh = index_surface<W>(surface, control);
      if (!fresh.is_ok()) return fresh.status();
      built = std::move(*fresh);
      index.built_primitives += surface->parts.size();
    }
    index.surfaces.back() = built;
    index.shapes.back() = built->shape();
  }
  return Status::ok();
}

// Boxes of places in world space. Those of parts hold them as they are; in the world they are parts
// of patches of rounded points, which may lie farther out by what the farthest control point is
// rounded by.
template <int W>
std::vector<Bounds3f> boxes_of_places(const PlacedBvh<W>& index) {
  std::vector<std::vector<Bounds3f>> below_root(index.surfaces.size());
  for (std::size_t s = 0; s < index.surfaces.size(); ++s) {
    if (!index.surfaces[s]) continue;
    const BvhNode<W>& root = index.surfaces[s]->structure.nodes[0];
    for (int i = 0; i < W; ++i) {
      if (root.child[i] != kBvhNoChild) below_root[s].push_back(child_box(root, i));
    }
  }
  std::vector<Bounds3f> boxes;
  boxes.reserve(index.patches->shared.places.size());
  for (const InstanceBlock& place : index.patches->shared.places) {
    const PlaceRoundings off(place, index.surfaces[place.mesh]->surface->points);
    boxes.push_back(off.grown(placed_bounds(to_world_of(place), below_root[place.mesh])));
  }
  return boxes;
}

}  // namespace

template <int W>
TrianglesAndPlaces<W> PlacedBvh<W>::kernel_shapes() const {
  const SharedPlaces& shared = patches->shared;
  return {blocks.data(),
          triangles.data(),
          patches->parts.data(),
          patches->patches.data(),
          static_cast<std::uint32_t>(patches->parts.size()),
          shared.first_number,
          shared.places.data(),
          shapes.data()};
}

template <int W>
std::uint64_t PlacedBvh<W>::memory_bytes() const {
  std::uint64_t bytes = structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t) +
                        triangles.capacity() * sizeof(TriangleBlock<W>) +
                        surfaces.capacity() * (sizeof(surfaces[0]) + sizeof(shapes[0]));
  for (const auto& surface : surfaces) {
    if (surface) bytes += surface->memory_bytes();
  }
  return bytes;
}

template <int W>
Result<PlacedBvh<W>> index_places(const PatchedParts& parts,
                                  std::shared_ptr<const PatchStore> patches,
                                  const PlacedBvh<W>* known, const BuildControl& control) {
  PlacedBvh<W> index;
  index.patches = std::move(patches);
  TESSERA_RETURN_IF_ERROR(index_surfaces(known, control, index));
  std::vector<Bounds3f> boxes(parts.boxes.begin(), parts.boxes.end());
  const auto triangles = static_cast<std::uint32_t>(boxes.size());
  boxes.insert(boxes.end(), parts.part_boxes.begin(), parts.part_boxes.end());
  Bounds3f flattened;
  for (const Bounds3f& box : boxes) flattened.grow(box);
  const std::vector<Bounds3f> of_places = boxes_of_places(index);
  boxes.insert(boxes.end(), of_places.begin(), of_places.end());
  std::vector<std::uint32_t> items(boxes.size() - triangles);
  std::iota(items.begin(), items.end(), triangles);
  MixedWriter<W> writer(parts.vertices, items);
  Result<Bvh<W>> bvh = build_bvh<W>({boxes, writer, triangles}, control);
  if (!bvh.is_ok()) return bvh.status();
  index.structure = std::move(*bvh);
  index.blocks = writer.take_blocks();
  index.triangles = writer.take_triangles();
  index.built_primitives += boxes.size();
  for (TriangleBlock<W>& block : index.triangles) {
    for (std::uint32_t& primitive : block.primitive) {
      if (primitive < triangles) primitive = parts.numbers[primitive];
    }
  }
  index.bounds = exact_place_bounds(index, of_places, flattened);
  return index;
}

template TrianglesAndPlaces<8> PlacedBvh<8>::kernel_shapes() const;
template TrianglesAndPlaces<16> PlacedBvh<16>::kernel_shapes() const;
template std::uint64_t PlacedBvh<8>::memory_bytes() const;
template std::uint64_t PlacedBvh<16>::memory_bytes() const;
template Result<PlacedBvh<8>> index_places<8>(const PatchedParts&,
                                              std::shared_ptr<const PatchStore>,
                                              const PlacedBvh<8>*, const BuildControl&);
template Result<PlacedBvh<16>> index_places<16>(const PatchedParts&,
                                                std::shared_ptr<const PatchStore>,
                                                const PlacedBvh<16>*, const BuildControl&);

}  // namespace tessera::core
