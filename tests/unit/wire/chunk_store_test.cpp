// SPDX-License-Identifier: Apache-2.0
// Chunks of a block in any order: memory is paid for by bytes that came, and what comes out is the
// block. Pages are counted by the kernel (mincore), in the ranges that the store gives out.
#include "common/wire/chunk_store.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "common/wire/block_assembly.h"

namespace tessera::wire {
namespace {

using Bytes = std::vector<std::byte>;
constexpr std::uint64_t kMib = 1024 * 1024;

Bytes random_bytes(std::uint64_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}
std::span<const std::byte> chunk_of(const Bytes& block, std::uint32_t index) {
  return std::span(block).subspan(std::size_t{index} * kSceneChunkBytes,
                                  chunk_bytes(block.size(), index));
}

// Bytes of pages that take memory in the range of a block, which begins where chunk 0 has its
// place.
std::uint64_t resident_bytes(const std::byte* begin, std::uint64_t size) {
  constexpr std::uint64_t kPageBytes = 4096;
  std::vector<unsigned char> pages((size + kPageBytes - 1) / kPageBytes);
  auto* const place = const_cast<std::byte*>(begin);
  EXPECT_EQ(::mincore(place, size, pages.data()), 0);
  const auto count =
      std::count_if(pages.begin(), pages.end(), [](unsigned char p) { return (p & 1u) != 0; });
  return static_cast<std::uint64_t>(count) * kPageBytes;
}

TEST(ChunkStore, GivesBackTheBlockWhateverTheOrder) {
  std::mt19937 random(7);
  for (const std::uint64_t size :
       {std::uint64_t{1}, kSceneChunkBytes - 1, kSceneChunkBytes, kSceneChunkBytes + 1,
        ChunkStore::kInPlaceBytesMin - 1, ChunkStore::kInPlaceBytesMin,
        ChunkStore::kInPlaceBytesMin + 1, 3 * ChunkStore::kInPlaceBytesMin + 4097}) {
    const Bytes block = random_bytes(size, static_cast<std::uint32_t>(size));
    std::vector<std::uint32_t> order(chunk_count(size));
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), random);
    ChunkStore store(size);
    std::vector<net::SharedBytes> handed_out;
    for (const std::uint32_t index : order) {
      store.put(index, chunk_of(block, index));
      handed_out.push_back(store.chunk(index));
    }
    const BlockBytes whole = store.finish();
    EXPECT_TRUE(std::ranges::equal(*whole, block)) << size;
    for (std::size_t i = 0; i < order.size(); ++i)
      EXPECT_TRUE(std::ranges::equal(handed_out[i].bytes, chunk_of(block, order[i]))) << size;
  }
}

TEST(ChunkStore, TheLastChunkFirstTakesItsOwnMemoryAlone) {
  ChunkStore store(kSceneBlockBytesMax);
  const Bytes chunk = random_bytes(kSceneChunkBytes, 1);
  store.put(kSceneBlockChunksMax - 1, chunk);
  const std::byte* const begin =
      store.chunk(kSceneBlockChunksMax - 1).bytes.data() - (kSceneBlockBytesMax - kSceneChunkBytes);
  EXPECT_EQ(resident_bytes(begin, kSceneBlockBytesMax), kSceneChunkBytes);
}

TEST(ChunkStore, ChunksInAnyOrderTakeWhatCame) {
  constexpr std::uint32_t kChunks = 400;
  std::vector<std::uint32_t> order(kSceneBlockChunksMax);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  order.resize(kChunks);
  ChunkStore store(kSceneBlockBytesMax);
  const Bytes chunk = random_bytes(kSceneChunkBytes, 2);
  for (const std::uint32_t index : order) store.put(index, chunk);
  const std::byte* const begin =
      store.chunk(order[0]).bytes.data() - std::uint64_t{order[0]} * kSceneChunkBytes;
  const std::uint64_t received = std::uint64_t{kChunks} * kSceneChunkBytes;
  EXPECT_LE(resident_bytes(begin, kSceneBlockBytesMax), received + received / 10 + kMib);
}

// A last chunk of one byte would take a page at its place, for each of 65,536 blocks.
TEST(ChunkStore, AShortLastChunkHasNoPageOfItsOwn) {
  const Bytes block = random_bytes(ChunkStore::kInPlaceBytesMin + 1, 4);
  ChunkStore store(block.size());
  const auto last = static_cast<std::uint32_t>(chunk_count(block.size()) - 1);
  store.put(last, chunk_of(block, last));
  EXPECT_EQ(store.chunk(last).bytes.size(), 1u);
  store.put(0, chunk_of(block, 0));
  EXPECT_EQ(resident_bytes(store.chunk(0).bytes.data(), block.size()), kSceneChunkBytes);
}

TEST(BlockAssembly, AChunkWithAnotherDigestTakesNoMemory) {
  const Bytes block = random_bytes(2 * ChunkStore::kInPlaceBytesMin, 5);
  const ChunkDigests digests = chunk_digests(block);
  BlockAssembly assembly(block_digest(block.size(), digests), block.size());
  ASSERT_TRUE(assembly.set_list(digests));
  EXPECT_EQ(assembly.put(31, chunk_of(block, 30)), BlockAssembly::Put::kWrong);
  EXPECT_EQ(assembly.have_bytes(), 0u);
  EXPECT_EQ(assembly.put(31, chunk_of(block, 31)), BlockAssembly::Put::kStored);
  EXPECT_EQ(assembly.put(31, chunk_of(block, 31)), BlockAssembly::Put::kKnown);
  const std::byte* const begin = assembly.chunk(31).bytes.data() - 31 * kSceneChunkBytes;
  EXPECT_EQ(resident_bytes(begin, block.size()), kSceneChunkBytes);
}

}  // namespace
}  // namespace tessera::wire
