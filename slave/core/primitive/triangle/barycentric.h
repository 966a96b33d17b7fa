// SPDX-License-Identifier: Apache-2.0
// Barycentric coordinates of hits, for plain numbers: the text of barycentric-inl.h.
// Threads. Pure function.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "common/math/vec3d.h"
#include "slave/core/primitive/triangle/barycentric-inl.h"

namespace tessera::core {

// One object serves rays from one origin.
class Barycentric {
 public:
  Barycentric(Vec3f origin, Vec3f a, Vec3f b, Vec3f c)
      : of_origin_(widened(origin), widened(a), widened(b), widened(c)) {}

  // Requires: the ray meets the triangle.
  Vec2f of(Vec3f direction) const {
    const auto [u, v] = of_origin_.of(widened(direction));
    return {u, v};
  }

 private:
  plain::Barycentric<double> of_origin_;
};

// Returns: the barycentric coordinates of one ray's hit. Requires: the ray meets the triangle.
inline Vec2f barycentric(Vec3f origin, Vec3f direction, Vec3f a, Vec3f b, Vec3f c) {
  return Barycentric(origin, a, b, c).of(direction);
}

}  // namespace tessera::core
