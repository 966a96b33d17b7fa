// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/kernels/kernel_table.h"

namespace tessera::core {
namespace {

TEST(Isa, ScalarIsAlwaysThereAndEverySupportedSetHasItsTable) {
  EXPECT_NE(0u, supported_isas() & isa_bit(Isa::kScalar));
  EXPECT_EQ(0u, supported_isas() & ~kIsaMaskAll);
  const int lanes[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i) {
    const Isa isa = static_cast<Isa>(i);
    if ((supported_isas() & isa_bit(isa)) == 0) continue;
    EXPECT_EQ(isa, kernels_for(isa).isa);
    EXPECT_EQ(lanes[i], kernels_for(isa).lane_count);
  }
}

#if defined(__x86_64__) && !defined(TESSERA_FEW_INSTRUCTION_SETS)  // sanitizers have two sets
TEST(Isa, TheBuildHoldsAllFourSetsOnX86) { EXPECT_EQ(kIsaMaskAll, compiled_isas()); }
#endif

}  // namespace
}  // namespace tessera::core
