// SPDX-License-Identifier: Apache-2.0
// The render times of a slave's last tiles, for the bounds that are computed from them: how long a
// lost tile takes to be rendered again, and when a tile is overdue.
//
// Threads. A plain value of its owner.
//
// Invariants. At most kTilesKept times are held; the oldest leaves first.
#pragma once

#include <cstddef>
#include <vector>

namespace tessera::master {

class TileTimes {
 public:
  // Enough for a 95th percentile of a few frames: with fewer than 20 it is the greatest.
  static constexpr std::size_t kTilesKept = 128;

  // Requires: seconds is finite and not negative.
  void add(double seconds);
  const std::vector<double>& seconds() const { return seconds_; }  // in no order

 private:
  std::vector<double> seconds_;
  std::size_t next_ = 0;
};

// The value below which `share` of the values lie (nearest rank); 0 when there are none.
// Requires: 0 < share <= 1.
double quantile(std::vector<double> values, double share);

}  // namespace tessera::master
