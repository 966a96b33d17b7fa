// SPDX-License-Identifier: Apache-2.0
// What a slave says of a tile's cost, cut to what can be true. Its figures are shown, summed and
// decided by, and nothing but the pixels is ever checked against another's.
//
// Threads. Pure.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/wire/messages.h"

namespace tessera::master {

// No processor traces more in a second on one thread; the fastest measured here are below 1e8.
inline constexpr double kRaysPerSecondMax = 1e10;

// `lease_seconds`: how long ago the tile was leased, which no render can have taken longer than;
// `session_seconds`: how long the slave can have been here; `threads`: those that it has.
inline void cut_to_possible(double lease_seconds, double session_seconds, std::uint32_t threads,
                            wire::TileResult& result) {
  const auto cut = [](double value, double most) {
    return value > 0 ? std::min(value, std::max(most, 0.0)) : 0.0;  // also NaN
  };
  result.seconds = cut(result.seconds, lease_seconds);
  result.held_seconds = cut(result.held_seconds, lease_seconds);
  result.starved_seconds = cut(result.starved_seconds, session_seconds * threads);
  const double rays_max = std::clamp(lease_seconds, 0.0, 1e8) * kRaysPerSecondMax;
  const auto most = static_cast<std::uint64_t>(rays_max);
  for (std::uint64_t* rays : {&result.rays.primary, &result.rays.shadow, &result.rays.secondary})
    *rays = std::min(*rays, most);
}

}  // namespace tessera::master
