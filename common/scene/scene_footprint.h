// SPDX-License-Identifier: Apache-2.0
// What a slave takes in memory for a scene besides its blocks and their decoded form: triangles and
// patches in world space and the spatial index over them, at the peak of its build. The estimate is
// made from the blocks as they are, so that the master can give it before it sends them.
//
// Per triangle, from the layouts of slave/core: 36 bytes of vertices
// (primitive/triangle/triangle_store.h), 24 of its box while the index is built, and what the index
// takes with its builder's arrays; the sum is kIndexBytesPerTriangle. tests/unit/core measures that
// a slave stays below it.
//
// A mesh that stands so often that its copies would take much is built once, and each place where
// it stands takes kIndexBytesPerInstance. Meshes that shed light are copied all the same, since
// each of their triangles is a lamp; so are places whose matrix has no inverse, all meshes of a
// scene with patches, and everything where a slave makes a kd-tree: such a slave reckons that
// itself before it builds, and refuses with one line (slave/core/scene/prepared_scene.h).
//
// Patches: how many sub-patches they are cut into depends on their shape, from one to a thousand,
// so whoever can cut patches (slave/core/scene/patch_footprint.h) is asked for each surface.
// Without it 160 sub-patches a patch are assumed, as the teapot has where there are not many, and
// of a point of a trimming loop what it takes where a thousand loops lie one in the other.
//
// Mip levels of textures take a third of their bytes, and while they are built the level in work
// takes 15/16 of one texture in floats (slave/core/surface/texture.h): both are estimated as 4/3 of
// the bytes of all textures. An environment map counts as a texture: sampling takes 10 bytes for
// each of its texels of 12 bytes (sky_map.h). Emitters, some 130 bytes for each triangle that sheds
// light, are left out.
//
// Threads. Pure functions; SceneFootprint: one at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/scene/root_block.h"
#include "common/scene/scene_codec.h"
#include "common/scene/surface_sharing.h"

namespace tessera {

inline constexpr std::uint64_t kIndexBytesPerTriangle = 320;
inline constexpr std::uint64_t kIndexBytesPerInstance = 640;
// A mesh is built once where its copies beside the first would have so many triangles, about 100
// bytes each. Tracing instances costs time, so memory has to be worth it.
inline constexpr std::uint64_t kSharedTrianglesMin = std::uint64_t{1} << 19;
// A surface of patches without trims is split once where its copies beside the first would have so
// many patches, some 800 bytes each; a place of it takes what an instance does, or is flattened
// (surface_sharing.h). What a thread keeps of such surfaces in world space, from its first ray on,
// takes up to kPlacedPartsBytes; as many as kPlacedPartsThreads threads are reckoned with, and more
// slaves rarely have. A part takes a bit at each place where some surface of the scene lets
// rays pass.
inline constexpr std::uint64_t kSharedPatchesMin = std::uint64_t{1} << 16;
inline constexpr std::uint64_t kPlacedPartsBytes = 832 << 10;
inline constexpr std::uint64_t kPlacedPartsThreads = 16;
inline constexpr std::uint64_t kIndexBytesPerPatch = 160 * 450;
inline constexpr std::uint64_t kIndexBytesPerTrimPoint = 8192;
inline constexpr std::uint64_t kIndexBytesOfThreads = 5 << 20;  // that build, whatever they build

// Returns: the bytes that preparing a surface takes where it is flattened `copies` times, in a
// scene whose instances have `patches` patches in all; 0 for a block that cannot be read.
using SurfaceBytes = std::function<std::uint64_t(const SceneBlock& surface, std::uint64_t copies,
                                                 std::uint64_t patches)>;

// Reckons version after version; blocks that a version shares with the one before are not read
// again.
class SceneFootprint {
 public:
  // Returns: an estimate of the bytes; 0 for blocks that cannot be read (decoding will refuse
  // them).
  std::uint64_t index_bytes_of(const EncodedScene& scene, const SurfaceBytes& surface_bytes = {});
  // primitive_counts_of().
  PrimitiveCounts counts_of(const EncodedScene& scene);

 private:
  // What a block holds, whichever kind it is of.
  struct Content {
    PrimitiveCounts mesh, surface;
    std::uint64_t picture_bytes = 0;
    // Of a mesh or a surface, each once; null: none. Blocks with the same digest share them.
    std::shared_ptr<const std::vector<std::uint32_t>> materials;
    bool is_trimmed = false;            // a surface with lists of trims
    std::optional<SurfaceReach> reach;  // of a surface whose places have been asked for
  };
  // Where a surface stands.
  struct SurfacePlaces {
    std::uint64_t all = 0, flattened = 0;
    bool is_shared = false;  // by those that are not flattened
  };

  // Returns: false for a scene whose root cannot be read, or does not fit its blocks.
  bool read(const EncodedScene& scene, Scene& root, BlockCounts& counts);
  PrimitiveCounts counts_of(const Scene& root, const BlockCounts& counts) const;
  std::uint64_t mesh_bytes(const Scene& root, const BlockCounts& counts, bool has_patches) const;
  std::vector<SurfacePlaces> surface_places(const EncodedScene& scene, const Scene& root,
                                            const BlockCounts& counts);
  std::uint64_t patch_bytes(const EncodedScene& scene, const Scene& root, const BlockCounts& counts,
                            std::uint64_t patches, const SurfaceBytes& surface_bytes);

  BlockTable::Trace seen_;
  std::vector<Content> blocks_;
};

std::uint64_t index_bytes_of(const EncodedScene& scene, const SurfaceBytes& surface_bytes = {});

}  // namespace tessera
