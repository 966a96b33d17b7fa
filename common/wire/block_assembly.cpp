// SPDX-License-Identifier: Apache-2.0
#include "common/wire/block_assembly.h"

#include <utility>

#include "common/base/check.h"

namespace tessera::wire {

BlockAssembly::BlockAssembly(const Digest& digest, std::uint64_t size_bytes)
    : digest_(digest), size_bytes_(size_bytes), store_(size_bytes) {
  if (is_one_chunk(size_bytes)) chunks_ = {digest};
}

bool BlockAssembly::set_list(ChunkDigests chunks) {
  if (chunks.size() != count() || block_digest(size_bytes_, chunks) != digest_) return false;
  chunks_ = std::move(chunks);
  return true;
}

BlockAssembly::Put BlockAssembly::put(std::uint32_t index, std::span<const std::byte> bytes) {
  TESSERA_CHECK(has_list() && index < count());
  TESSERA_CHECK_EQ(bytes.size(), chunk_bytes(size_bytes_, index));
  if (has(index)) return Put::kKnown;
  if (sha256(bytes) != chunks_[index]) return Put::kWrong;
  store_.put(index, bytes);
  count_in(index);
  return Put::kStored;
}

void BlockAssembly::put_checked(std::uint32_t index, std::span<const std::byte> bytes) {
  TESSERA_CHECK(has_list() && index < count());
  TESSERA_CHECK_EQ(bytes.size(), chunk_bytes(size_bytes_, index));
  store_.put(index, bytes);
  count_in(index);
}

void BlockAssembly::count_in(std::uint32_t index) {
  if (have_.empty()) have_.resize(count());
  have_[index] = true;
  ++have_count_;
  have_bytes_ += chunk_bytes(size_bytes_, index);
}

std::vector<bool> BlockAssembly::lacking() const {
  std::vector<bool> lacking(count(), true);
  for (std::uint32_t i = 0; i < have_.size(); ++i) lacking[i] = !have_[i];
  return lacking;
}

net::SharedBytes BlockAssembly::chunk(std::uint32_t index) const {
  TESSERA_CHECK(has(index));
  return store_.chunk(index);
}

SceneBlock BlockAssembly::finish() {
  TESSERA_CHECK(is_whole());
  SceneBlock block;
  block.digest = digest_;
  if (!is_one_chunk(size_bytes_)) {
    block.chunks = std::make_shared<const ChunkDigests>(std::move(chunks_));
  }
  block.bytes = store_.finish();
  return block;
}

}  // namespace tessera::wire
