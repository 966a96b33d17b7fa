// SPDX-License-Identifier: Apache-2.0
// A ray as patches see it, and where it meets one.
// Threads. Plain values.
#pragma once

#include <limits>

namespace tessera::core {

// Points O + t D with t in [t_min, t_max]. D need not have length 1.
struct PatchRay {
  float origin[3];
  float direction[3];
  float t_min = 0, t_max = std::numeric_limits<float>::infinity();
};

struct PatchHit {
  bool is_hit = false;
  double t = 0, u = 0, v = 0;  // u, v: the patch's own, within the sub-patch's range
};

}  // namespace tessera::core
