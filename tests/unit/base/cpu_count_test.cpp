// SPDX-License-Identifier: Apache-2.0
// Quotas rounded to threads; lists of processors as people write them.
#include "common/base/cpu_count.h"

#include <gtest/gtest.h>

#include "common/base/limits.h"

namespace tessera {
namespace {

TEST(CpuCount, RoundsQuotasUpAndKeepsToItsBounds) {
  EXPECT_EQ(cpu_count_of(8, 0), 8);
  EXPECT_EQ(cpu_count_of(8, 1.5), 2);
  EXPECT_EQ(cpu_count_of(8, 0.1), 1);
  EXPECT_EQ(cpu_count_of(2, 64), 2);
  EXPECT_EQ(cpu_count_of(2, 1e300), 2);
  EXPECT_EQ(cpu_count_of(0, 0), 1);
  EXPECT_EQ(cpu_count_of(10'000, 0), kWorkersMax);
}

TEST(CpuCount, ReadsHowManyAndWhich) {
  const std::vector<int> allowed{0, 1, 2, 3, 8, 9};
  EXPECT_EQ(*parse_cpus("2", allowed), (std::vector<int>{0, 1}));
  EXPECT_EQ(*parse_cpus("6", allowed), allowed);
  EXPECT_EQ(*parse_cpus("2-2", allowed), std::vector<int>{2});
  EXPECT_EQ(*parse_cpus("8,1-3", allowed), (std::vector<int>{1, 2, 3, 8}));
  for (const char* wrong : {"", "0", "7", "-1", "a", "1-", "3-1", "1,,2", "0-9", "1-99999999999"})
    EXPECT_FALSE(parse_cpus(wrong, allowed).is_ok()) << wrong;
}

TEST(CpuCount, ThisProcessMayUseAtLeastOne) {
  EXPECT_GE(available_cpu_count(), 1);
  EXPECT_LE(available_cpu_count(), static_cast<int>(allowed_cpus().size()));
}

}  // namespace
}  // namespace tessera
