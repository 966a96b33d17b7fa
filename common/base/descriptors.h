// SPDX-License-Identifier: Apache-2.0
// How many files and connections this process may have open, and how near it is to that. The kernel
// gives each new one the lowest free number, so that a number near the limit says that nearly all
// below it are taken.
//
// Threads. Any.
#pragma once

#include <algorithm>

namespace tessera {

// Descriptors that are kept for what must go on when there are no more: status clients, the second
// connections of slaves that have been let in, files that are opened for a moment.
inline constexpr int kDescriptorReserveMax = 256;

// Of small limits a quarter is kept.
constexpr int descriptor_reserve(int limit) { return std::min(kDescriptorReserveMax, limit / 4); }
constexpr bool is_in_reserve(int descriptor, int limit) {
  return descriptor >= limit - descriptor_reserve(limit);
}

// The limit now; where the system does not say it, the least that POSIX allows.
int descriptor_limit();

// Raises the limit to what the person or unit that started the process allows: a usual shell gives
// 1,024, which 500 slaves pass, and allows a million. Returns: the limit afterwards.
int raise_descriptor_limit();

}  // namespace tessera
