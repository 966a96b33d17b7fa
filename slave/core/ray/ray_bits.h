// SPDX-License-Identifier: Apache-2.0
// Rays of a packet as bits of a number: bit i is ray i.
// Threads. Pure functions.
#pragma once

#include <bit>
#include <cstdint>

namespace tessera::core {

// Calls for each ray of the mask, lowest first.
template <class Function>
void for_each_ray(std::uint64_t rays, const Function& function) {
  for (; rays != 0; rays &= rays - 1) function(std::countr_zero(rays));
}

}  // namespace tessera::core
