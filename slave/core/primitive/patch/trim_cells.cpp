// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_cells.h"

#include <algorithm>
#include <bit>

namespace tessera::core {

bool TrimCells::is_odd_in_order(const TrimOrder& order, double u, double v,
                                TrimSteps& steps) const {
  const double x = order.n_u * u + order.n_v * v;
  const TrimRange* const of = ranges.data() + order.range;
  const auto* const end = std::upper_bound(
      of, of + order.ordered, x, [](double at, const TrimRange& r) { return at < double{r.low}; });
  auto i = static_cast<std::uint32_t>(end - of);
  steps.cells += static_cast<std::uint64_t>(std::bit_width(order.ordered));
  bool is_odd = false;
  for (; i > 0 && double{of[i - 1].high_so_far} >= x; --i) {
    ++steps.pieces;
    is_odd ^= double{of[i - 1].high} < x || counts(listed[order.first + i - 1], u, v, steps.points);
  }
  // The point is above all that are left.
  return is_odd != (i % 2 != 0);
}

}  // namespace tessera::core
