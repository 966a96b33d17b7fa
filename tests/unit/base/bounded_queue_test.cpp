// SPDX-License-Identifier: Apache-2.0
#include "common/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace tessera {
namespace {

TEST(BoundedQueue, RefusesWhatIsAboveItsCapacity) {
  BoundedQueue<int> queue(2);
  EXPECT_TRUE(queue.try_push(1));
  EXPECT_TRUE(queue.try_push(2));
  EXPECT_FALSE(queue.try_push(3));
  EXPECT_EQ(queue.try_pop(), 1);
  EXPECT_TRUE(queue.try_push(3));
}

TEST(BoundedQueue, KeepsOrderBetweenThreads) {
  constexpr int kCount = 20'000;
  BoundedQueue<int> queue(8);
  std::vector<int> taken;
  std::thread consumer([&] {
    while (auto element = queue.pop()) taken.push_back(*element);
  });
  for (int i = 0; i < kCount; ++i) {
    while (!queue.try_push(i)) std::this_thread::yield();
  }
  queue.close();
  consumer.join();
  ASSERT_EQ(taken.size(), static_cast<std::size_t>(kCount));
  for (int i = 0; i < kCount; ++i) ASSERT_EQ(taken[static_cast<std::size_t>(i)], i);
}

TEST(BoundedQueue, CloseLetsWaitersEndAndWhatIsQueuedOut) {
  BoundedQueue<int> queue(4);
  ASSERT_TRUE(queue.try_push(7));
  queue.close();
  EXPECT_FALSE(queue.try_push(8));
  EXPECT_EQ(queue.pop(), 7);
  EXPECT_EQ(queue.pop(), std::nullopt);
  BoundedQueue<int> waited(1);
  std::thread waiter([&] { EXPECT_EQ(waited.pop(), std::nullopt); });
  waited.close();
  waiter.join();
}

TEST(BoundedQueue, RemovesWhatIsLeftBehindAndKeepsTheRestInOrder) {
  BoundedQueue<int> queue(8);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(queue.try_push(i));
  EXPECT_EQ(queue.remove_if([](int i) { return i % 2 == 0; }).size(), 3u);
  EXPECT_EQ(queue.try_pop(), 1);
  EXPECT_EQ(queue.try_pop(), 3);
  EXPECT_EQ(queue.try_pop(), 5);
}

}  // namespace
}  // namespace tessera
