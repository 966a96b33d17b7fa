// SPDX-License-Identifier: Apache-2.0
// Property: the fit finds the costs that blocks were made from, in spite of noise and
// interruptions.
#include "tests/bench/cost_fit.h"

#include <gtest/gtest.h>

#include <random>

namespace tessera::bench {
namespace {

TEST(CostFit, FindsTheCostsThatBlocksWereMadeFrom) {
  const std::uint32_t seed = 42;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(0.9, 1.1);
  CostFit fit;
  for (int number = 0; number < 1000; ++number) {
    core::KernelCounts counts{};
    counts.packets = 16;
    counts.nodes = 50 + random() % 400;
    counts.blocks = counts.nodes / 2 + random() % 100;
    counts.row_tests = random() % 2000;
    double cycles = 100.0 * 16 + 80.0 * static_cast<double>(counts.nodes) +
                    120.0 * static_cast<double>(counts.blocks) +
                    15.0 * static_cast<double>(counts.row_tests);
    cycles *= noise(random);
    if (number % 100 == 0) cycles *= 50;  // something else ran
    fit.add(counts, cycles);
  }
  const CostFit::Costs costs = fit.fit();
  EXPECT_NEAR(costs[2], 80, 8);
  EXPECT_NEAR(costs[3], 120, 12);
  EXPECT_NEAR(costs[5], 15, 1.5);
  EXPECT_EQ(costs[1], 0);  // never happened
  EXPECT_EQ(costs[6], 0);
}

TEST(CostFit, NoCostIsBelowZero) {
  CostFit fit;
  for (std::uint64_t n = 1; n < 20; ++n) {
    core::KernelCounts counts{};
    counts.nodes = n;
    counts.blocks = n * n;
    fit.add(counts, 1000.0 * static_cast<double>(n) - static_cast<double>(n * n));
  }
  for (const double cost : fit.fit()) EXPECT_GE(cost, 0);
}

}  // namespace
}  // namespace tessera::bench
