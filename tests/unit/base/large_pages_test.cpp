// SPDX-License-Identifier: Apache-2.0
#include "common/base/large_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "common/base/uninitialized_allocator.h"

namespace tessera {
namespace {

// Sanitizers bring heaps of their own, whose arrays share the ranges that the kernel knows.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kHeapIsTheSystems = false;
#else
constexpr bool kHeapIsTheSystems = true;
#endif

// Returns: whether the kernel was asked for large pages where an array begins; null where this
// kernel does not say so, or has none.
std::optional<bool> is_on_large_pages(const void* array) {
  if (!std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled")) return {};
  std::ifstream maps("/proc/self/smaps");
  const auto address = reinterpret_cast<std::uintptr_t>(array);
  bool is_here = false;
  for (std::string line; std::getline(maps, line);) {
    const std::size_t dash = line.find('-');
    const bool is_range = dash != std::string::npos && dash < line.find(' ');
    if (is_range) {
      is_here = std::stoull(line, nullptr, 16) <= address &&
                address < std::stoull(line.substr(dash + 1), nullptr, 16);
    } else if (is_here && line.starts_with("VmFlags:")) {
      return line.find(" hg") != std::string::npos;
    }
  }
  return {};
}

TEST(LargePages, ArraysFromTheBoundOnAndNoSmallerOnes) {
  void* const small = take_array(kLargePagesFromBytes - 1, 64);
  void* const large = take_array(kLargePagesFromBytes, 64);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(small) % 64, 0u);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(large) % kLargePageBytes, 0u);
  if (kHeapIsTheSystems) {
    EXPECT_FALSE(is_on_large_pages(small).value_or(false));
    EXPECT_TRUE(is_on_large_pages(large).value_or(true));
  }
  give_array_back(small, kLargePagesFromBytes - 1, 64);
  give_array_back(large, kLargePagesFromBytes, 64);
}

TEST(LargePages, ArraysThatGrowPastTheBoundKeepWhatTheyHold) {
  std::vector<std::uint64_t, UninitializedAllocator<std::uint64_t>> numbers;
  const std::uint64_t count = kLargePagesFromBytes / sizeof(std::uint64_t) + 1000;
  for (std::uint64_t i = 0; i < count; ++i) numbers.push_back(i);
  for (std::uint64_t i = 0; i < count; ++i) ASSERT_EQ(numbers[i], i);
}

}  // namespace
}  // namespace tessera
