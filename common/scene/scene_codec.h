// SPDX-License-Identifier: Apache-2.0
// A scene as content-addressed blocks, which tessera-import hands over, the master keeps and
// broadcasts, and slaves cache. A block is one mesh, one surface, one texture, the environment map,
// the animation, or the root (everything small, with the others by block index). Equal content has
// equal bytes, hence an equal digest, so an update sends only blocks that the receiver lacks.
//
// Bytes. Little-endian, arrays length-prefixed by uint64 counts; layout in common/scene/README.md.
// Every count is checked against the bytes present before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/base/digest.h"
#include "common/base/shared_table.h"
#include "common/base/status.h"
#include "common/scene/block_chunks.h"
#include "common/scene/scene.h"
#include "common/scene/validate.h"

namespace tessera {

// The bytes of a block, which live as long as somebody holds them.
using BlockBytes = std::shared_ptr<const std::span<const std::byte>>;
BlockBytes block_bytes_of(std::vector<std::byte> bytes);
// Bytes that `owner` keeps where they are.
BlockBytes shared_block_bytes(std::shared_ptr<const void> owner, std::span<const std::byte> bytes);

struct SceneBlock {
  Digest digest;  // block_chunks.h
  BlockBytes bytes;
  // The digests of the block's chunks; null for a block that is one chunk.
  std::shared_ptr<const ChunkDigests> chunks;
};
SceneBlock make_scene_block(std::vector<std::byte> bytes);
using BlockTable = SharedTable<SceneBlock>;

// Block 0 is the root; the others are in the order in which the root refers to them.
struct EncodedScene {
  BlockTable blocks;
  std::uint64_t index_bytes = 0;  // by index_bytes_of() (scene_footprint.h); 0: not estimated
  double time_seconds = 0;        // at which it is shown; of animated scenes alone
  std::uint64_t total_bytes() const;
  Digest digest() const;     // the scene's identity: scene_summary.h
  bool is_animated() const;  // whether a SceneAnimation is one of the blocks
};

// What the flattened scene consists of, from the blocks' counts alone; zeros when they cannot be
// read. An instance of a mesh or surface that is not there counts nothing.
struct PrimitiveCounts {
  std::uint64_t triangles = 0, patches = 0;
  std::uint64_t numbers = 0;      // of control points: 3 or 4 each
  std::uint64_t trim_points = 0;  // of the patches' loops
};
PrimitiveCounts primitive_counts_of(const EncodedScene& scene);

// Encodes meshes, surfaces and textures; a caller that encodes version after version keeps one
// SceneEncoder, which remembers the block of each of them by pointer and hashes only new ones: an
// object is looked for at its place in the version before, and then among all. Used by one thread.
class SceneEncoder {
 public:
  // Requires: validate_scene(scene) is ok.
  EncodedScene encode(const Scene& scene);

 private:
  struct Known {
    std::shared_ptr<const void> object;
    SceneBlock block;
  };
  // The objects of the version before, in the order of their blocks, and its blocks. What is in
  // the same chunk as none that changed is shared with them.
  std::vector<Known> known_;
  BlockTable before_;
};

// Decodes block after block; the cache shares meshes, surfaces and textures with earlier versions
// by digest: a mesh is looked for at its place in the version before, and then among all. Where the
// scene of the version before still lives, blocks of chunks that both share are not looked at. Used
// by one thread.
class SceneDecoder {
 public:
  // Returns: kDataLoss for malformed bytes, or validate_scene()'s refusal. Requires: the caller has
  // checked the digests.
  Result<Scene> decode(const EncodedScene& encoded);
  // The same of a scene that is not changed; the next version takes what it can from it.
  Result<std::shared_ptr<const Scene>> decode_shared(const EncodedScene& encoded);

 private:
  struct PlacedMesh {
    Digest digest;
    std::weak_ptr<const Mesh> mesh;
  };

  // Returns: null for malformed bytes.
  std::shared_ptr<const Mesh> mesh_of(const SceneBlock& block, PlacedMesh& before);
  Status decode_meshes(const EncodedScene& encoded, std::size_t count, const Scene* before,
                       Scene& scene);
  void forget_expired();
  // `before`: the newest scene of decode_shared(), or null.
  Status decode_into(const EncodedScene& encoded, const Scene* before, Scene& scene);

  std::vector<PlacedMesh> placed_;  // the meshes of the version before
  std::unordered_map<Digest, std::weak_ptr<const Mesh>, DigestHash> meshes_;
  std::unordered_map<Digest, std::weak_ptr<const PatchSurface>, DigestHash> surfaces_;
  std::unordered_map<Digest, std::weak_ptr<const Texture>, DigestHash> textures_;
  std::unordered_map<Digest, std::weak_ptr<const EnvironmentMap>, DigestHash> environments_;
  std::unordered_map<Digest, std::weak_ptr<const SceneAnimation>, DigestHash> animations_;
  SceneValidator validator_;

  std::weak_ptr<const Scene> newest_;  // of decode_shared()
  BlockTable::Trace newest_blocks_;    // of it
};

}  // namespace tessera
