// SPDX-License-Identifier: Apache-2.0
// How many tiles may be rendered twice on purpose. Pure.
//
// Each tile done earns a hundredth of a duplicate, and four more hundredths for tiles that
// stragglers hold. So extra work stays below 1 % in a cluster of equals and below 5 % with
// stragglers, whatever the tail of one frame looks like. What is saved up is bounded, so that a
// long quiet stretch does not pay for a burst.
//
// Threads. One owner.
#pragma once

#include <algorithm>

namespace tessera::master {

class DuplicationBudget {
 public:
  static constexpr double kShare = 0.01, kStragglerShare = 0.04;
  static constexpr double kSavedMax = 8, kStragglerSavedMax = 32;

  void tile_done() {
    saved_ = std::min(saved_ + kShare, kSavedMax);
    straggler_saved_ = std::min(straggler_saved_ + kStragglerShare, kStragglerSavedMax);
  }

  // Takes one duplicate out of the budget. Returns: false when there is none left.
  bool take(bool is_of_straggler) {
    double& saved = is_of_straggler && straggler_saved_ >= 1 ? straggler_saved_ : saved_;
    if (saved < 1) return false;
    saved -= 1;
    return true;
  }

 private:
  double saved_ = 0, straggler_saved_ = 0;
};

}  // namespace tessera::master
