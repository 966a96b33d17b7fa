// SPDX-License-Identifier: Apache-2.0
// What the kernel's files say about memory, as texts.
#include "common/base/memory_room.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

MemoryTexts machine() {
  MemoryTexts texts;
  texts.meminfo = "MemTotal:        8388608 kB\nMemFree:  100 kB\nMemAvailable:    4194304 kB\n";
  texts.own_status = "Name:\tx\nVmRSS:\t  102400 kB\n";
  return texts;
}

TEST(MemoryRoom, OfAMachineWithoutLimits) {
  const auto room = memory_room(machine(), std::nullopt, 0);
  ASSERT_TRUE(room.has_value());
  EXPECT_EQ(room->limit_bytes, 8192 * kMib);
  EXPECT_EQ(room->free_bytes, 4096 * kMib);
  EXPECT_FALSE(memory_room({}, std::nullopt, 0).has_value());
}

TEST(MemoryRoom, OfAControlGroup) {
  const auto room = memory_room(machine(), CgroupMemory{1024 * kMib, 524 * kMib}, 0);
  EXPECT_EQ(room->limit_bytes, 1024 * kMib);
  EXPECT_EQ(room->free_bytes, 524 * kMib);
  // A group may be allowed more than the machine has.
  const auto wide = memory_room(machine(), CgroupMemory{16384 * kMib, 16000 * kMib}, 0);
  EXPECT_EQ(wide->limit_bytes, 8192 * kMib);
  EXPECT_EQ(wide->free_bytes, 4096 * kMib);
}

TEST(MemoryRoom, OfAPerson) {
  const auto room = memory_room(machine(), std::nullopt, 300 * kMib);
  EXPECT_EQ(room->limit_bytes, 300 * kMib);
  EXPECT_EQ(room->free_bytes, 200 * kMib);
  EXPECT_EQ(memory_room(machine(), std::nullopt, 50 * kMib)->free_bytes, 0u);
}

}  // namespace
}  // namespace tessera
