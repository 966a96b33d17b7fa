// SPDX-License-Identifier: Apache-2.0
#include "master/display/newest_slot.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace tessera::master {
namespace {

TEST(NewestSlot, DropsWhatWasNotTaken) {
  NewestSlot<std::shared_ptr<int>> slot;
  EXPECT_FALSE(slot.take().has_value());
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = first;
  slot.put(std::move(first));
  slot.put(std::make_shared<int>(2));
  EXPECT_TRUE(watched.expired());  // its pixels do not wait for the window
  slot.put(std::make_shared<int>(3));
  EXPECT_FALSE(slot.is_empty());
  const auto taken = slot.take();
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(**taken, 3);
  EXPECT_TRUE(slot.is_empty());
  EXPECT_FALSE(slot.take().has_value());
  EXPECT_EQ(slot.put_count(), 3u);
}

TEST(NewestSlot, ReaderSeesRisingValuesAndTheLast) {
  constexpr int kCount = 20000;
  NewestSlot<int> slot;
  std::thread writer([&] {
    for (int i = 1; i <= kCount; ++i) slot.put(i);
  });
  int last = 0;
  while (last < kCount) {
    if (const auto value = slot.take()) {
      ASSERT_GT(*value, last);
      last = *value;
    } else {
      std::this_thread::yield();
    }
  }
  writer.join();
  EXPECT_EQ(slot.put_count(), static_cast<std::uint64_t>(kCount));
}

}  // namespace
}  // namespace tessera::master
