// SPDX-License-Identifier: Apache-2.0
// A block of a scene as a list of chunks of one size, each with its own digest. So an update sends
// only the chunks that changed, a reconnecting peer goes on where it was, and a relay passes on
// what it has before it has all.
//
// A block's digest is a Merkle root of one level. For a block that fits into a chunk it is the
// SHA-256 of its bytes, for a larger one the SHA-256 of its list (a tag that no block begins with,
// its size, the digests of its chunks in order). So a list can be checked against the block's
// digest, and each chunk against the list, before another byte is believed. Why chunks have one
// fixed size, and what else was measured, stands in README.md.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/digest.h"
#include "common/base/limits.h"

namespace tessera {

using ChunkDigests = std::vector<Digest>;

constexpr bool is_one_chunk(std::uint64_t block_bytes) { return block_bytes <= kSceneChunkBytes; }
constexpr std::uint32_t chunk_count(std::uint64_t block_bytes) {
  return static_cast<std::uint32_t>((block_bytes + kSceneChunkBytes - 1) / kSceneChunkBytes);
}
// The last chunk may be shorter. Requires: index < chunk_count(block_bytes).
constexpr std::uint64_t chunk_bytes(std::uint64_t block_bytes, std::uint32_t index) {
  const std::uint64_t rest = block_bytes - std::uint64_t{index} * kSceneChunkBytes;
  return rest < kSceneChunkBytes ? rest : kSceneChunkBytes;
}

// Returns: the list of a block that is larger than a chunk; empty for a block that is not.
ChunkDigests chunk_digests(std::span<const std::byte> block);

// The digest of a block from its list. Requires: a list of chunk_count(block_bytes) > 1 digests.
Digest block_digest(std::uint64_t block_bytes, const ChunkDigests& chunks);

}  // namespace tessera
