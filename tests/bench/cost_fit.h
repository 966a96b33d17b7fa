// SPDX-License-Identifier: Apache-2.0
// What a step costs: cycles of blocks of rays, explained by the steps that were counted in them.
//
// Least squares over the blocks, with no cost below zero; blocks that took more than four times
// their due are left out once, for something else ran. Steps that always come together share their
// cost in no certain way, so the figures are good to some 20 %.
//
// Threads. Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "slave/core/simd/counts_layout.h"

namespace tessera::bench {

class CostFit {
 public:
  static constexpr int kKinds = 7;
  static constexpr const char* kNames[kKinds] = {"packet",   "single",   "node", "block",
                                                 "triangle", "row test", "exact"};
  using Costs = std::array<double, kKinds>;

  void add(const core::KernelCounts& counts, double cycles);
  // Cycles of one of each; 0 for what never happened.
  Costs fit() const;
  // Share of all cycles that each takes, given its cost.
  Costs shares(const Costs& costs) const;
  double cycles() const;
  bool is_empty() const { return blocks_.empty(); }

 private:
  struct Block {
    Costs steps;
    double cycles;
  };
  static Costs solve(const std::vector<Block>& blocks);
  std::vector<Block> blocks_;
};

// The time stamp counter, or nanoseconds where there is none.
std::uint64_t time_stamp();

}  // namespace tessera::bench
