// SPDX-License-Identifier: Apache-2.0
// The window that rays from one point pass, found from the outermost of them.
//
// Threads. Pure function.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "common/math/vec3.h"
#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// The window that rays between the given ones pass, also where their directions are rounded: it is
// wider by 16 roundings of a direction. Returns: nothing where the rays are too far apart for a
// fan.
inline std::optional<FanWindow> fan_window(Vec3f origin, std::span<const Vec3f> outermost) {
  Vec3f sum{};
  for (const Vec3f d : outermost) sum = sum + d;
  const int larger = std::fabs(sum.x) >= std::fabs(sum.y) ? 0 : 1;
  FanWindow window{};
  window.axis = std::fabs(sum[larger]) >= std::fabs(sum.z) ? larger : 2;
  window.side = sum[window.axis] < 0 ? -1.0f : 1.0f;
  for (int a = 0; a < 3; ++a) window.origin[a] = origin[a];
  for (int k = 0; k < 2; ++k) {
    window.low[k] = INFINITY;
    window.high[k] = -INFINITY;
    for (const Vec3f d : outermost) {
      const float depth = d[window.axis] * window.side;
      const float slope = d[(window.axis + 1 + k) % 3] / depth;
      if (!(depth > 0 && std::fabs(slope) <= 2)) return std::nullopt;
      const float slack = 0x1p-20f * (1 + std::fabs(slope));
      window.low[k] = std::fmin(window.low[k], slope - slack);
      window.high[k] = std::fmax(window.high[k], slope + slack);
    }
  }
  return window;
}

}  // namespace tessera::core
