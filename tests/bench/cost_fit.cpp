// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/cost_fit.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#ifdef __x86_64__
#include <x86intrin.h>
#endif

namespace tessera::bench {
namespace {

constexpr int kKinds = CostFit::kKinds;
using Matrix = std::array<std::array<double, kKinds + 1>, kKinds>;

// Gauss-Jordan elimination on the rows and columns that are in use. Pivots are on the diagonal,
// since the matrix is symmetric and positive. The costs of kinds that are not in use are 0.
CostFit::Costs eliminate(Matrix m, const std::array<bool, kKinds>& is_used) {
  for (std::size_t i = 0; i < kKinds; ++i) {
    if (!is_used[i]) continue;
    for (std::size_t row = 0; row < kKinds; ++row) {
      if (row == i || !is_used[row]) continue;
      const double factor = m[row][i] / m[i][i];
      for (std::size_t column = 0; column <= kKinds; ++column)
        m[row][column] -= factor * m[i][column];
    }
  }
  CostFit::Costs result{};
  for (std::size_t i = 0; i < kKinds; ++i) {
    if (is_used[i]) result[i] = m[i][kKinds] / m[i][i];
  }
  return result;
}

double cost_of(const CostFit::Costs& steps, const CostFit::Costs& costs) {
  return std::inner_product(steps.begin(), steps.end(), costs.begin(), 0.0);
}

}  // namespace

void CostFit::add(const core::KernelCounts& c, double cycles) {
  const std::uint64_t steps[kKinds] = {c.packets,    c.singles,   c.nodes, c.blocks,
                                       c.candidates, c.row_tests, c.exact};
  Block block{{}, cycles};
  for (std::size_t i = 0; i < kKinds; ++i) block.steps[i] = static_cast<double>(steps[i]);
  blocks_.push_back(block);
}

CostFit::Costs CostFit::solve(const std::vector<Block>& blocks) {
  Matrix normal{};
  for (const Block& block : blocks) {
    for (std::size_t i = 0; i < kKinds; ++i) {
      for (std::size_t k = 0; k < kKinds; ++k) normal[i][k] += block.steps[i] * block.steps[k];
      normal[i][kKinds] += block.steps[i] * block.cycles;
    }
  }
  std::array<bool, kKinds> is_used{};
  for (std::size_t i = 0; i < kKinds; ++i) is_used[i] = normal[i][i] > 0;
  while (true) {
    const Costs costs = eliminate(normal, is_used);
    const auto least = std::min_element(costs.begin(), costs.end());
    if (!(*least < 0)) return costs;
    is_used[static_cast<std::size_t>(least - costs.begin())] = false;
  }
}

CostFit::Costs CostFit::fit() const {
  const Costs first = solve(blocks_);
  std::vector<Block> kept;
  for (const Block& block : blocks_) {
    if (block.cycles <= 4 * cost_of(block.steps, first)) kept.push_back(block);
  }
  return solve(kept);
}

double CostFit::cycles() const {
  return std::accumulate(blocks_.begin(), blocks_.end(), 0.0,
                         [](double sum, const Block& block) { return sum + block.cycles; });
}

CostFit::Costs CostFit::shares(const Costs& costs) const {
  Costs shares{};
  for (const Block& block : blocks_) {
    for (std::size_t i = 0; i < kKinds; ++i) shares[i] += block.steps[i] * costs[i];
  }
  for (double& share : shares) share /= cycles();
  return shares;
}

std::uint64_t time_stamp() {
#ifdef __x86_64__
  return __rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace tessera::bench
