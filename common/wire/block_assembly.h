// SPDX-License-Identifier: Apache-2.0
// A block of a scene that is being received. It takes chunks in any order, believes none before its
// digest has been checked, and hands out the checked ones while others are still missing.
//
// Threads. One owner. Pure.
// Invariants. (1) Memory is taken as chunks come (ChunkStore), up to the announced size and never
// beyond. (2) A chunk that chunk() has handed out keeps its place and its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/digest.h"
#include "common/net/record.h"
#include "common/scene/block_chunks.h"
#include "common/scene/scene_codec.h"
#include "common/wire/chunk_store.h"

namespace tessera::wire {

class BlockAssembly {
 public:
  // A block of one chunk has its own digest as its list.
  BlockAssembly(const Digest& digest, std::uint64_t size_bytes);

  // Returns: false when the list does not have the block's digest.
  [[nodiscard]] bool set_list(ChunkDigests chunks);
  bool has_list() const { return !chunks_.empty(); }
  const ChunkDigests& list() const { return chunks_; }

  enum class Put { kStored, kKnown, kWrong };
  // Requires: has_list(), index < count(), as many bytes as the chunk has. Throws: std::bad_alloc.
  Put put(std::uint32_t index, std::span<const std::byte> bytes);
  // The same for bytes whose digest was checked before, and is the one that the list names.
  void put_checked(std::uint32_t index, std::span<const std::byte> bytes);

  std::uint32_t count() const { return chunk_count(size_bytes_); }
  std::uint64_t size_bytes() const { return size_bytes_; }
  const Digest& digest() const { return digest_; }
  bool has(std::uint32_t index) const { return !have_.empty() && have_[index]; }
  std::uint32_t have_count() const { return have_count_; }
  std::uint64_t have_bytes() const { return have_bytes_; }
  bool is_whole() const { return has_list() && have_count_ == count(); }
  std::vector<bool> lacking() const;  // [count()]

  // Requires: has(index).
  net::SharedBytes chunk(std::uint32_t index) const;
  // Requires: is_whole(). Throws: std::bad_alloc.
  SceneBlock finish();

 private:
  void count_in(std::uint32_t index);

  Digest digest_;
  std::uint64_t size_bytes_;
  ChunkDigests chunks_;
  ChunkStore store_;
  std::vector<bool> have_;
  std::uint32_t have_count_ = 0;
  std::uint64_t have_bytes_ = 0;
};

}  // namespace tessera::wire
