// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/cpu_count.h"
#include "common/base/isa.h"
#include "common/base/log.h"

namespace tessera {
namespace {

TEST(Isa, NamesRoundTripAndUnknownOnesNameTheRest) {
  for (int i = 0; i < 4; ++i) {
    const auto isa = parse_isa(isa_name(static_cast<Isa>(i)));
    ASSERT_TRUE(isa.is_ok());
    EXPECT_EQ(*isa, static_cast<Isa>(i));
  }
  EXPECT_NE(parse_isa("sse9").status().message().find("avx2"), std::string::npos);
}

TEST(Isa, WidestIsTheHighestBit) {
  EXPECT_EQ(widest_isa(isa_bit(Isa::kScalar) | isa_bit(Isa::kAvx2)), Isa::kAvx2);
  EXPECT_EQ(widest_isa(isa_bit(Isa::kScalar)), Isa::kScalar);
}

TEST(Log, UnknownLevelNamesTheRest) {
  EXPECT_TRUE(parse_log_level("warn").is_ok());
  EXPECT_NE(parse_log_level("loud").status().message().find("debug"), std::string::npos);
}

TEST(CpuCount, IsAtLeastOne) { EXPECT_GE(available_cpu_count(), 1); }

}  // namespace
}  // namespace tessera
