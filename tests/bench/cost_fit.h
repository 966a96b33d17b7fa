// SPDX-License-Identifier: Apache-2.0
// Estimates what each kind of traversal step costs, from the cycles of blocks of rays and the steps
// that were counted in them.
//
// The fit is by least squares over the blocks, with no cost below zero. Blocks that took more than
// four times the fitted cycles are left out and the rest are fitted again, since something else ran
// during them. Steps that always come together share their cost in no certain way, so the figures
// are good to some 20 %.
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
  // Returns: cycles of one step of each kind; 0 for kinds that never happened.
  Costs fit() const;
  // Returns: the share of all cycles that each kind of step takes, given its cost.
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
