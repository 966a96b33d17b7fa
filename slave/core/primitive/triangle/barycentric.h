// SPDX-License-Identifier: Apache-2.0
// Where in a triangle a ray meets it, for the hits that are kept in the end: kernels decide and
// compare without it. Threads. Pure function.
#pragma once

#include <algorithm>

#include "common/math/vec3.h"

namespace tessera::core {

// P = (1 - u - v) A + u B + v C; u, v and 1 - u - v are in [0, 1] whatever the rounding. In double,
// in coordinates relative to A: the error is some 2^-50 s over the triangle's height as the ray
// sees it, s the distance of the ray's origin from A. One object serves rays from one origin.
//
// After Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
class Barycentric {
 public:
  Barycentric(Vec3f origin, Vec3f a, Vec3f b, Vec3f c)
      : edge_b_(difference(b, a)),
        edge_c_(difference(c, a)),
        from_(difference(origin, a)),
        across_(cross_of(from_, edge_b_)) {}

  // Requires: the ray meets the triangle.
  Vec2f of(Vec3f direction) const {
    const V d{direction.x, direction.y, direction.z};
    const V p = cross_of(d, edge_c_);
    const double volume = dot_of(edge_b_, p);
    // A hit triangle is never seen edge-on; the products of its extents may vanish all the same.
    if (!(volume != 0)) return {0, 0};
    const auto share = [&](double value) {
      return static_cast<float>(std::clamp(value / volume, 0.0, 1.0) + 0.0);  // no -0
    };
    const float u = share(dot_of(from_, p)), v = share(dot_of(d, across_));
    return {u, std::min(v, 1 - u)};
  }

 private:
  struct V {
    double x, y, z;
  };
  static V difference(Vec3f p, Vec3f q) {
    return {double{p.x} - q.x, double{p.y} - q.y, double{p.z} - q.z};
  }
  static V cross_of(V p, V q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  }
  static double dot_of(V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

  V edge_b_, edge_c_, from_, across_;
};

// Of one ray.
inline Vec2f barycentric(Vec3f origin, Vec3f direction, Vec3f a, Vec3f b, Vec3f c) {
  return Barycentric(origin, a, b, c).of(direction);
}

}  // namespace tessera::core
