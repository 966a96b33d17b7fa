// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_cells.h"

#include <algorithm>
#include <bit>

namespace tessera::core {
namespace {

// How many of the ranges, count >= 1, have a low up to x: a guess, as if lows were spread evenly,
// or by halves.
std::uint32_t lows_up_to(float x, const TrimRange* of, std::uint32_t count) {
  const float share = (x - of[0].low) / (of[count - 1].low - of[0].low);  // or no number
  const float place = share > 0 ? std::min(share, 1.0f) * static_cast<float>(count - 1) : 0;
  auto up_to = static_cast<std::uint32_t>(place);
  up_to += static_cast<std::uint32_t>(of[up_to].low <= x);
  const bool is_less = up_to > 0 && of[up_to - 1].low > x;
  const bool is_more = up_to < count && of[up_to].low <= x;
  if (!is_less && !is_more) return up_to;
  up_to = 0;
  for (std::uint32_t left = count; left > 0;) {
    const std::uint32_t half = left - left / 2;
    up_to += half * static_cast<std::uint32_t>(of[up_to + half - 1].low <= x);
    left -= half;
  }
  return up_to;
}

}  // namespace

bool TrimCells::is_odd_in_order(const TrimOrder& order, double u, double v,
                                TrimSteps& steps) const {
  // Rounding is monotonic, so what lies in a range does so then.
  const auto x = static_cast<float>(order.across(u, v));
  const TrimRange* const of = ranges.data() + order.range;
  std::uint32_t i = lows_up_to(x, of, order.ordered);
  steps.cells += static_cast<std::uint64_t>(std::bit_width(order.ordered));
  bool is_odd = false;
  for (; i > 0 && of[i - 1].high_so_far >= x; --i) {
    ++steps.pieces;
    is_odd ^= counts(listed[order.first + i - 1], u, v, steps.points);
  }
  // The point is above all that are left.
  return is_odd != (i % 2 != 0);
}

}  // namespace tessera::core
