// SPDX-License-Identifier: Apache-2.0
// What the kernels have done, for tables and profiles: counted only where the project is configured
// with TESSERA_COUNTING (preset "counting"), for counting costs time.
//
// Threads. Each thread has its own counts.
#pragma once

#include <stdint.h>

namespace tessera::core {

struct KernelCounts {
  uint64_t packets;     // fans and bundles traced as a frustum
  uint64_t singles;     // rays traced by themselves
  uint64_t nodes;       // whose children were compared with a ray or a frustum
  uint64_t children;    // found to be met
  uint64_t blocks;      // of triangles looked at
  uint64_t candidates;  // triangles left of them after culling
  uint64_t row_tests;   // triangle against a row of rays
  uint64_t times;       // rows, or single rays, for which t was computed
  uint64_t exact;       // rays decided by exact_hit()
};

#ifdef TESSERA_COUNTING
inline thread_local KernelCounts kernel_counts{};
#define TESSERA_COUNT(field, number) (kernel_counts.field += static_cast<uint64_t>(number))
#else
#define TESSERA_COUNT(field, number) static_cast<void>(0)
#endif

}  // namespace tessera::core
