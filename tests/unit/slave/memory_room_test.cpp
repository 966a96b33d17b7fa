// What the kernel's files say about memory, as texts.
#include "slave/memory_room.h"

#include <gtest/gtest.h>

namespace tessera::slave {
namespace {

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

MemoryTexts machine() {
  MemoryTexts texts;
  texts.meminfo = "MemTotal:        8388608 kB\nMemFree:  100 kB\nMemAvailable:    4194304 kB\n";
  texts.own_status = "Name:\tx\nVmRSS:\t  102400 kB\n";
  return texts;
}

TEST(MemoryRoom, OfAMachineWithoutLimits) {
  const auto room = memory_room(machine(), 0);
  ASSERT_TRUE(room.has_value());
  EXPECT_EQ(room->limit_bytes, 8192 * kMib);
  EXPECT_EQ(room->free_bytes, 4096 * kMib);
  EXPECT_FALSE(memory_room({}, 0).has_value());
}

TEST(MemoryRoom, OfAControlGroup) {
  MemoryTexts texts = machine();
  texts.group_limit = std::to_string(1024 * kMib) + "\n";
  texts.group_usage = std::to_string(700 * kMib) + "\n";
  texts.group_stat = "cache 1\ninactive_file " + std::to_string(200 * kMib) + "\nactive_file 5\n";
  const auto room = memory_room(texts, 0);
  EXPECT_EQ(room->limit_bytes, 1024 * kMib);
  EXPECT_EQ(room->free_bytes, 524 * kMib) << "pages of files are given back";
  texts.group_limit = "max\n";
  EXPECT_EQ(memory_room(texts, 0)->limit_bytes, 8192 * kMib);
  texts.group_limit = "9223372036854771712\n";  // version 1's none
  EXPECT_EQ(memory_room(texts, 0)->limit_bytes, 8192 * kMib);
}

TEST(MemoryRoom, OfAPerson) {
  const auto room = memory_room(machine(), 300 * kMib);
  EXPECT_EQ(room->limit_bytes, 300 * kMib);
  EXPECT_EQ(room->free_bytes, 200 * kMib);
  EXPECT_EQ(memory_room(machine(), 50 * kMib)->free_bytes, 0u);
}

}  // namespace
}  // namespace tessera::slave
