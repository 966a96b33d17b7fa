// SPDX-License-Identifier: Apache-2.0
#include "common/wire/chunk_store.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace tessera::wire {

void ChunkStore::put(std::uint32_t index, std::span<const std::byte> bytes) {
  if (size_bytes_ < kInPlaceBytesMin || bytes.size() < kSceneChunkBytes) {
    loose_.emplace(index, net::SharedBytes::of({bytes.begin(), bytes.end()}));
    return;
  }
  if (!pages_) pages_ = std::make_shared<SparseBytes>(size_bytes_);
  const std::span<std::byte> place =
      pages_->bytes().subspan(std::size_t{index} * kSceneChunkBytes, bytes.size());
  std::copy(bytes.begin(), bytes.end(), place.begin());
}

net::SharedBytes ChunkStore::chunk(std::uint32_t index) const {
  if (const auto loose = loose_.find(index); loose != loose_.end()) return loose->second;
  TESSERA_CHECK(pages_ != nullptr);
  const std::span<const std::byte> bytes = pages_->bytes();
  return {pages_, bytes.subspan(std::size_t{index} * kSceneChunkBytes, kSceneChunkBytes)};
}

BlockBytes ChunkStore::finish() {
  if (!pages_) {
    std::vector<std::byte> whole;
    whole.reserve(static_cast<std::size_t>(size_bytes_));
    for (const auto& [index, chunk] : loose_)
      whole.insert(whole.end(), chunk.bytes.begin(), chunk.bytes.end());
    loose_.clear();
    return block_bytes_of(std::move(whole));
  }
  for (const auto& [index, chunk] : loose_) {
    const std::size_t begin = std::size_t{index} * kSceneChunkBytes;
    std::copy(chunk.bytes.begin(), chunk.bytes.end(), pages_->bytes().subspan(begin).begin());
  }
  loose_.clear();
  std::shared_ptr<const SparseBytes> pages = std::move(pages_);
  const std::span<const std::byte> bytes = pages->bytes();
  return shared_block_bytes(std::move(pages), bytes);
}

}  // namespace tessera::wire
