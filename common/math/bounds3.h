// SPDX-License-Identifier: Apache-2.0
// Axis-parallel box, closed: a point on a face is inside. A fresh box is empty (lower > upper).
// Threads. Plain values. Points are finite: vertices are checked where a scene enters, and boxes of
// them stay finite.
#pragma once

#include <limits>

#include "common/math/vec3.h"

namespace tessera {

struct Bounds3f {
  static constexpr float kInf = std::numeric_limits<float>::infinity();
  Vec3f lower{kInf, kInf, kInf};
  Vec3f upper{-kInf, -kInf, -kInf};

  bool is_empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }
  Vec3f extent() const { return upper - lower; }
  void grow(Vec3f p) {
    lower = min(lower, p);
    upper = max(upper, p);
  }
  void grow(const Bounds3f& b) {
    lower = min(lower, b.lower);
    upper = max(upper, b.upper);
  }
};

}  // namespace tessera
