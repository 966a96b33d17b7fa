// SPDX-License-Identifier: Apache-2.0
// A scene receiver whose memory runs out, at each of the places where it takes some: the version
// in work has failed, and those behind it are served.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <utility>

#include "common/wire/scene_receiver.h"

namespace {

long allocations_left = -1;  // until one is refused; negative: none is

}  // namespace

// These three are never inlined: a compiler that sees into one of a pair alone takes it for a
// mismatch of new and free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace tessera::wire {
namespace {

using Actions = SceneReceiver::Actions;
using Bytes = std::vector<std::byte>;

// The messages that bring version 1, and version 2, which has one block more and no other.
struct Delivery {
  SceneAnnounce first, second;
  SceneChunkList list;
  std::vector<SceneChunk> chunks;
  SceneChunk of_second;

  Delivery() {
    const Bytes root(100, std::byte{1}), large(2 * kSceneChunkBytes, std::byte{2});
    const Bytes last(100, std::byte{3});
    first.version = 1;
    second.version = 2;
    for (const Bytes& block : {root, large, last}) {
      for (SceneAnnounce* announce : {&first, &second}) {
        if (announce == &first && block == last) continue;
        announce->digests.push_back(make_scene_block(block).digest);
        announce->sizes.push_back(block.size());
      }
    }
    const Bytes half(kSceneChunkBytes, std::byte{2});
    list = {1, 1, chunk_digests(large)};
    chunks = {{1, 0, 0, net::SharedBytes::of(root)},
              {1, 1, 0, net::SharedBytes::of(half)},
              {1, 1, kSceneChunkBytes, net::SharedBytes::of(half)}};
    of_second = {2, 2, 0, net::SharedBytes::of(last)};
  }
};

// Returns: whether all memory was there.
bool try_refusing(const Delivery& delivery, long allocation) {
  SceneReceiver receiver;
  Actions actions;
  EXPECT_TRUE(receiver.announce(delivery.first, actions).is_ok());
  EXPECT_TRUE(receiver.announce(delivery.second, actions).is_ok());
  SceneChunkList list = delivery.list;
  allocations_left = allocation;
  bool is_ok = receiver.list(std::move(list), actions).is_ok();
  for (const SceneChunk& chunk : delivery.chunks) is_ok &= receiver.chunk(chunk, actions).is_ok();
  const bool was_there = allocations_left >= 0;
  allocations_left = -1;
  EXPECT_TRUE(is_ok) << "the peer broke no rule, allocation " << allocation;
  bool has_second = false;
  for (const SceneFailed& failed : actions.failed) has_second |= failed.version == 2;
  EXPECT_EQ(actions.failed.size() + actions.complete.size(), has_second ? 2u : 1u) << allocation;
  if (has_second) return was_there;
  EXPECT_EQ(receiver.head_version(), 2u) << "the next one is served, allocation " << allocation;
  if (!actions.failed.empty()) return was_there;
  EXPECT_TRUE(receiver.chunk(delivery.of_second, actions).is_ok());
  EXPECT_EQ(actions.complete.size(), 2u) << allocation;
  return was_there;
}

TEST(SceneReceiverMemory, AVersionFailsWhereverMemoryRunsOut) {
  const Delivery delivery;
  long allocation = 0;
  while (!try_refusing(delivery, allocation) && !HasFailure()) ++allocation;
  std::printf("%ld allocations refused, one at a time\n", allocation);
  EXPECT_GT(allocation, 20);
}

// Takes the chunks from a peer that did not announce them, and again those that found no memory.
// Returns: whether all memory was there.
bool try_refusing_a_peer(const Delivery& delivery, long allocation) {
  SceneReceiver receiver;
  Actions actions;
  EXPECT_TRUE(receiver.announce(delivery.first, actions).is_ok());
  EXPECT_TRUE(receiver.list(delivery.list, actions).is_ok());
  allocations_left = allocation;
  std::vector<SceneReceiver::Verdict> verdicts(delivery.chunks.size());
  for (std::size_t i = 0; i < delivery.chunks.size(); ++i)
    verdicts[i] = receiver.take(delivery.chunks[i], actions);
  const bool was_there = allocations_left >= 0;
  allocations_left = -1;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i] != SceneReceiver::Verdict::kNoMemory) continue;
    EXPECT_TRUE(actions.failed.empty()) << "nothing has failed, allocation " << allocation;
    EXPECT_EQ(receiver.take(delivery.chunks[i], actions), SceneReceiver::Verdict::kStored) << i;
  }
  EXPECT_EQ(actions.complete.size() + actions.failed.size(), 1u) << allocation;
  return was_there;
}

TEST(SceneReceiverMemory, AChunkOfAnotherPeerCanComeAgainWhereMemoryWasRefused) {
  const Delivery delivery;
  long allocation = 1;  // the first is that of the list of verdicts
  while (!try_refusing_a_peer(delivery, allocation) && !HasFailure()) ++allocation;
  EXPECT_GT(allocation, 5);
}

}  // namespace
}  // namespace tessera::wire
