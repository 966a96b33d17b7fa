// SPDX-License-Identifier: Apache-2.0
// Runs work of one thread on each processor in turn: processors of one machine differ, by their
// clock or by what their neighbours leave of the caches, and the system chooses where a thread
// runs.
//
// Threads. One; its mask changes while work runs and is as before thereafter.
#pragma once

#include <sched.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/base/cpu_count.h"

namespace tessera::bench {

// Of more processors than these, the first ones stand for all.
inline constexpr std::size_t kTurnCpusMax = 4;

class CpuTurns {
 public:
  CpuTurns() : cpus_(allowed_cpus()) {
    has_mask_ = sched_getaffinity(0, sizeof(mask_), &mask_) == 0;
    cpus_.resize(std::min(cpus_.size(), kTurnCpusMax));
    if (cpus_.empty()) cpus_.push_back(0);
  }

  std::size_t count() const { return cpus_.size(); }

  // Calls work() on the i-th processor of count(). Where the system refuses the mask, the work runs
  // wherever it puts it.
  template <typename Work>
  void on(std::size_t i, const Work& work) const {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(cpus_[i]), &one);
    if (has_mask_) (void)sched_setaffinity(0, sizeof(one), &one);
    work();
    if (has_mask_) (void)sched_setaffinity(0, sizeof(mask_), &mask_);
  }

 private:
  std::vector<int> cpus_;
  cpu_set_t mask_{};
  bool has_mask_ = false;
};

// Shape: seconds [processor][run]. Returns: the seconds of a processor of their mean speed, by the
// median of each one's runs. Requires: a run of each.
inline double seconds_at_mean_speed(std::vector<std::vector<double>> seconds) {
  double speed = 0;
  for (std::vector<double>& runs : seconds) {
    std::sort(runs.begin(), runs.end());
    speed += 2 / (runs[runs.size() / 2] + runs[(runs.size() - 1) / 2]);
  }
  return static_cast<double>(seconds.size()) / speed;
}

// Appends a run of the i-th processor, which has had none or follows the last that had one.
inline void add_run(std::vector<std::vector<double>>& seconds, std::size_t i, double run) {
  seconds.resize(std::max(seconds.size(), i + 1));
  seconds[i].push_back(run);
}

}  // namespace tessera::bench
