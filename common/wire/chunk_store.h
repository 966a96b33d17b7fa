// SPDX-License-Identifier: Apache-2.0
// The checked chunks of one block, in whatever order they come. Memory grows with what has come,
// and not with what was announced: 64 KiB for the last chunk of 8 GiB that is the first to come.
//
// A large block lies at its place from the start, in pages that the system gives as they are
// written (SparseBytes): nothing is zeroed, moved or copied once more. Chunks of a block below 1
// MiB, and the last one of any, which may be a few bytes long, are kept one by one until all are
// here.
//
// Threads. One owner. Pure but for memory.
// Invariants. (1) No more than the chunks' bytes is written, and a book-keeping of 200 bytes for
// each loose chunk. (2) A chunk that chunk() has handed out keeps its place and its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "common/base/sparse_bytes.h"
#include "common/net/record.h"
#include "common/scene/block_chunks.h"
#include "common/scene/scene_codec.h"

namespace tessera::wire {

class ChunkStore {
 public:
  // Blocks of fewer bytes are joined when all chunks are here, which copies so many bytes at most.
  static constexpr std::uint64_t kInPlaceBytesMin = 16 * kSceneChunkBytes;

  explicit ChunkStore(std::uint64_t size_bytes) : size_bytes_(size_bytes) {}

  // Requires: a chunk that is not here, with as many bytes as it has. Throws: std::bad_alloc.
  void put(std::uint32_t index, std::span<const std::byte> bytes);
  // Requires: the chunk was put.
  net::SharedBytes chunk(std::uint32_t index) const;
  // Takes the whole block out. Requires: all chunks were put. Throws: std::bad_alloc.
  BlockBytes finish();

 private:
  std::uint64_t size_bytes_;
  std::shared_ptr<SparseBytes> pages_;               // null until a chunk has its place there
  std::map<std::uint32_t, net::SharedBytes> loose_;  // by index
};

}  // namespace tessera::wire
