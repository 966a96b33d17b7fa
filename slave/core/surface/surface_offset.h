// SPDX-License-Identifier: Apache-2.0
// How far a secondary ray must start from a surface to be on the right side of it for certain.
//
// With u = 2^-24, triangle A, B, C, unit normal n, and P = A + (a (B - A) + b (C - A)) in float32:
//   - P against the exact plane, by component: difference, product and sum are 3 roundings of each
//     edge term, the last sum is one rounding of P: gamma(3) (|a (B-A)| + |b (C-A)|) + gamma(1)
//     |P|. Errors of a and b themselves move P within the plane and do not count.
//   - Adding the offset rounds once more: gamma(1) |P|; roundings of this bound: gamma(2) |P| in
//     all.
//   - The triangle test sees the plane displaced by its own error: a vertex at distance s from the
//     origin is moved by at most 6 u s when it is brought to the ray's frame, and the products of
//     the edge values move the point by another 2 u s for well-shaped triangles; twice that, 16 u
//     s, the tolerance of the whole project, also covers triangles of aspect up to about 4. s is
//     the largest component of the distance from P to a vertex.
// The distance to the plane counts, not the distance along the ray: at a grazing angle both the
// displacement and the offset grow by 1 / cos when measured along the ray.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/rounding.h"
#include "common/math/vec3.h"

namespace tessera::core {

inline Vec3f abs3(Vec3f v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }
inline float largest_component(Vec3f v) { return std::max(v.x, std::max(v.y, v.z)); }

// Whether the edges from A make an angle whose sine is below 2^-8: |b x c| < 2^-8 |b| |c|. The normal
// of any other triangle is good to 2^-14: a component of the product is off by 3 u |b| |c|, all of them
// by sqrt(3) as much, that is 5.2 u 2^8 of its length. Also for what under- or overflows.
inline constexpr float kSliverSine2 = 0x1p-16f;
inline bool is_sliver(Vec3f edge_b, Vec3f edge_c) {
  const Vec3f across = cross(edge_b, edge_c);
  return !(dot(across, across) >= kSliverSine2 * (dot(edge_b, edge_b) * dot(edge_c, edge_c)));
}

struct SurfacePoint {
  Vec3f point;
  float offset;  // along the unit normal, at least this far
};

inline SurfacePoint surface_point(Vec3f a, Vec3f edge_b, Vec3f edge_c, Vec3f normal, float u,
                                  float v) {
  const Vec3f along_b = edge_b * u, along_c = edge_c * v;
  const Vec3f within = along_b + along_c;
  const Vec3f p = a + within;
  const Vec3f error = (abs3(along_b) + abs3(along_c)) * gamma(3) + abs3(p) * gamma(4);
  float s = largest_component(abs3(within));
  s = std::max(s, largest_component(abs3(edge_b - within)));
  s = std::max(s, largest_component(abs3(edge_c - within)));
  return {p, dot(abs3(normal), error) + 16 * kUnitRoundoff * s};
}

}  // namespace tessera::core
