// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/tile_times.h"

#include <algorithm>
#include <cmath>

namespace tessera::master {

void TileTimes::add(double seconds) {
  if (seconds_.size() < kTilesKept) {
    seconds_.push_back(seconds);
  } else {
    seconds_[next_] = seconds;
    next_ = (next_ + 1) % kTilesKept;
  }
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  const std::size_t index = std::clamp<std::size_t>(rank, 1, values.size()) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index),
                   values.end());
  return values[index];
}

}  // namespace tessera::master
