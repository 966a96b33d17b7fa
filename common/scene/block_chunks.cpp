// SPDX-License-Identifier: Apache-2.0
#include "common/scene/block_chunks.h"

#include "common/base/check.h"

namespace tessera {
namespace {

// "TSSL", which is no block's first word (block_bytes.h), so that no block can pass for a list.
constexpr std::uint32_t kListTag = 0x4c535354;

}  // namespace

ChunkDigests chunk_digests(std::span<const std::byte> block) {
  ChunkDigests digests;
  if (is_one_chunk(block.size())) return digests;
  digests.reserve(chunk_count(block.size()));
  for (std::uint32_t i = 0; i < chunk_count(block.size()); ++i) {
    digests.push_back(
        sha256(block.subspan(std::size_t{i} * kSceneChunkBytes, chunk_bytes(block.size(), i))));
  }
  return digests;
}

Digest block_digest(std::uint64_t block_bytes, const ChunkDigests& chunks) {
  TESSERA_CHECK_EQ(chunks.size(), chunk_count(block_bytes));
  Sha256 hash;
  hash.update(std::as_bytes(std::span(&kListTag, 1)));
  hash.update(std::as_bytes(std::span(&block_bytes, 1)));
  hash.update(std::as_bytes(std::span(chunks)));
  return hash.finish();
}

}  // namespace tessera
