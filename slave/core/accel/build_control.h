// SPDX-License-Identifier: Apache-2.0
// How a builder of a spatial index is to run; all builders take it.
// Threads. is_cancelled may be set by any thread while a build runs; a build polls it.
#pragma once

#include <atomic>

#include "common/base/work_gate.h"

namespace tessera::core {

struct BuildControl {
  int thread_count = 1;                             // at least 1; counts the calling thread
  const std::atomic<bool>* is_cancelled = nullptr;  // may be null; polled

  // Asked between pieces of work, where a build also gives way to others.
  bool is_to_stop() const {
    give_way();
    return is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed);
  }
};

}  // namespace tessera::core
