// SPDX-License-Identifier: Apache-2.0
// What a person asked of a scene that moves, by keys since the window was opened.
// Threads. A plain value.
#pragma once

#include <cstdint>

namespace tessera::master {

struct PlayWish {
  bool is_paused = false;
  std::int64_t steps = 0;  // frames on, less frames back
  bool operator==(const PlayWish&) const = default;
};

}  // namespace tessera::master
