// SPDX-License-Identifier: Apache-2.0
// How a builder of a spatial index is to run; all builders take it.
// Threads. is_cancelled may be set by any thread while a build runs.
#pragma once

#include <atomic>

namespace tessera::core {

struct BuildControl {
  int thread_count = 1;                             // at least 1; counts the calling thread
  const std::atomic<bool>* is_cancelled = nullptr;  // may be null; polled
};

}  // namespace tessera::core
