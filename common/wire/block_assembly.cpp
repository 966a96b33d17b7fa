// SPDX-License-Identifier: Apache-2.0
#include "common/wire/block_assembly.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/base/check.h"

namespace tessera::wire {

BlockAssembly::BlockAssembly(const Digest& digest, std::uint64_t size_bytes)
    : digest_(digest), size_bytes_(size_bytes) {
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
  if (!bytes_) {
    // The memory is reserved and not filled: pages are touched as chunks come, and nothing moves.
    auto reserved = std::make_shared<std::vector<std::byte>>();
    reserved->reserve(static_cast<std::size_t>(size_bytes_));
    bytes_ = std::move(reserved);
    have_.resize(count());
  }
  const std::size_t begin = std::size_t{index} * kSceneChunkBytes;
  bytes_->resize(std::max(bytes_->size(), begin + bytes.size()));
  std::memcpy(bytes_->data() + begin, bytes.data(), bytes.size());
  have_[index] = true;
  ++have_count_;
  have_bytes_ += bytes.size();
  return Put::kStored;
}

std::vector<bool> BlockAssembly::lacking() const {
  std::vector<bool> lacking(count(), true);
  for (std::uint32_t i = 0; i < have_.size(); ++i) lacking[i] = !have_[i];
  return lacking;
}

net::SharedBytes BlockAssembly::chunk(std::uint32_t index) const {
  TESSERA_CHECK(has(index));
  return {bytes_, std::span<const std::byte>(*bytes_).subspan(std::size_t{index} * kSceneChunkBytes,
                                                              chunk_bytes(size_bytes_, index))};
}

SceneBlock BlockAssembly::finish() {
  TESSERA_CHECK(is_whole());
  SceneBlock block;
  block.digest = digest_;
  if (!is_one_chunk(size_bytes_)) {
    block.chunks = std::make_shared<const ChunkDigests>(std::move(chunks_));
  }
  block.bytes = std::move(bytes_);
  return block;
}

}  // namespace tessera::wire
