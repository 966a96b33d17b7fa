// SPDX-License-Identifier: Apache-2.0
// The acceleration structure of a scene, whichever it is, with the blocks of primitives that its
// leaves name.
//
// Threads. Built once, then never changed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/kd_index.h"
#include "slave/core/accel/structure.h"
#include "slave/core/primitive/places_layout.h"
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/primitive/triangle/triangle_blocks.h"

namespace tessera::core {

inline SceneBox scene_box(const Bounds3f& bounds) {
  SceneBox box{};
  for (int a = 0; a < 3; ++a) {
    box.lower[a] = bounds.lower[a];
    box.upper[a] = bounds.upper[a];
    box.farthest[a] = std::max(std::fabs(box.lower[a]), std::fabs(box.upper[a]));
  }
  return box;
}

template <class Structure, int W>
struct Indexed {
  Structure structure;
  TriangleBlocks<W> triangles;

  std::uint64_t memory_bytes() const {
    return structure.memory_bytes() + triangles.capacity() * sizeof(TriangleBlock<W>);
  }
};
template <int W>
using IndexedBvh = Indexed<Bvh<W>, W>;
template <int W>
using IndexedKd = Indexed<KdIndex<W>, W>;

// A hierarchy over instances, each a mesh with a hierarchy of its own, and over triangles that are
// flattened.
template <int W>
struct MeshIndex;
template <int W>
class MeshSlot;
template <int W>
struct FlatPart;
template <int W>
struct InstancedBvh {
  Bvh<W> structure;
  Bounds3f bounds;                    // of all corners; the structure's box is wider
  std::vector<std::uint32_t> blocks;  // as TrianglesAndInstances has them
  TriangleBlocks<W> triangles;
  std::vector<InstanceBlock> instances;
  std::vector<Bounds3f> boxes;  // of instances, world space
  // By mesh of the scene. Meshes without an instance here are null in `meshes` and `slots`, and
  // empty in `shapes`. Where what is flattened has a structure of its own, its shape comes last.
  std::vector<std::shared_ptr<const MeshIndex<W>>> meshes;
  std::vector<std::shared_ptr<MeshSlot<W>>> slots;  // of those that are built when a ray meets them
  std::vector<MeshShape<W>> shapes;
  std::vector<std::uint8_t> is_placed;  // by instance of the scene: 0 where it is flattened
  // For versions of the scene that follow:
  std::vector<bool> is_moving;  // by mesh of the scene
  std::shared_ptr<const FlatPart<W>> flat;
  std::int64_t farthest[6];  // who touches `bounds`: an instance, or -1, what is flattened
  std::uint64_t moves = 0;   // of instances, since the structure was built as a whole
  std::uint64_t built_primitives = 0;  // that this version put into structures

  std::uint64_t memory_bytes() const;
  // Triangles of the slots' meshes that are built by now.
  std::uint64_t met_primitives() const;
};

// A hierarchy over sub-patches and triangles.
struct PatchStore;
template <int W>
struct PatchedBvh {
  Bvh<W> structure;
  std::vector<std::uint32_t> blocks;  // as TrianglesAndPatches has them
  TriangleBlocks<W> triangles;
  std::shared_ptr<const PatchStore> patches;

  std::uint64_t memory_bytes() const {  // but for the patches
    return structure.memory_bytes() + blocks.capacity() * sizeof(std::uint32_t) +
           triangles.capacity() * sizeof(TriangleBlock<W>);
  }
};

// A hierarchy over places of shared surfaces, each of which has a hierarchy of its own, and over
// sub-patches and triangles that are flattened.
template <int W>
struct SurfaceIndex;
template <int W>
struct PlacedBvh {
  Bvh<W> structure;
  Bounds3f bounds;                    // as of the flattened scene; the structure's box is wider
  std::vector<std::uint32_t> blocks;  // as TrianglesAndPlaces has them
  TriangleBlocks<W> triangles;
  std::shared_ptr<const PatchStore> patches;  // with the places
  // By surface of the scene: null, and empty in `shapes`, where it is flattened.
  std::vector<std::shared_ptr<const SurfaceIndex<W>>> surfaces;
  std::vector<SurfaceShape<W>> shapes;
  std::uint64_t built_primitives = 0;  // that this version put into structures

  TrianglesAndPlaces<W> kernel_shapes() const;
  std::uint64_t memory_bytes() const;  // but for the patches
};

// Answers do not depend on the structure, only time does.
struct PrimitiveIndex {
  std::variant<IndexedBvh<8>, IndexedBvh<16>, IndexedKd<8>, IndexedKd<16>, InstancedBvh<8>,
               InstancedBvh<16>, PatchedBvh<8>, PatchedBvh<16>, PlacedBvh<8>, PlacedBvh<16>>
      any;

  std::uint64_t memory_bytes() const {
    return std::visit([](const auto& index) { return index.memory_bytes(); }, any);
  }
  // Bounds of all corners of triangles with an area; empty where there are none.
  Bounds3f bounds() const {
    return std::visit(
        [](const auto& index) {
          if constexpr (requires { index.bounds; })
            return index.bounds;
          else
            return index.structure.bounds;
        },
        any);
  }
};

// Shape: boxes [triangle_count], an empty one keeps its number and stays out; vertices
// [triangle_count][3][3]. Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<IndexedBvh<W>> index_by_bvh(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                   const BuildControl& control, const BvhBuildConfig& config = {});
template <int W>
Result<IndexedKd<W>> index_by_kd(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                 const BuildControl& control, const KdBuildConfig& config = {});

// The same by the fast build. Shape and returns: as above.
template <int W>
Result<IndexedBvh<W>> index_fast(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                 const BuildControl& control);

// Fits the index of triangles to where they are now. Returns: as above.
template <int W>
Result<IndexedBvh<W>> fit_index(const IndexedBvh<W>& built, std::span<const float> vertices,
                                const BuildControl& control);

// Builds the index for a processor with registers of `lanes` floats. Shape and returns: as above.
Result<PrimitiveIndex> build_primitive_index(std::span<const Bounds3f> boxes,
                                             std::span<const float> vertices, Structure structure,
                                             int lanes, const BuildControl& control);

}  // namespace tessera::core
