// SPDX-License-Identifier: Apache-2.0
// Directions about a normal. The same bits on every processor and C library: arithmetic and square
// roots only.
//
// Threads. Pure functions.
#pragma once

#include <cmath>

#include "common/math/vec3.h"

namespace tessera::core {

// sin and cos of 2 pi x, x in [-1/8, 1/8]. Taylor series to the ninth and eighth power: off by less
// than 2^-24 there, so that it is the rounding of float32 that remains.
struct SinCos {
  float sin, cos;
};
inline SinCos sin_cos_turn(float x) {
  const float a = 6.28318531f * x, b = a * a;
  return {a * (1 + b * (-1 / 6.0f + b * (1 / 120.0f + b * (-1 / 5040.0f + b * (1 / 362880.0f))))),
          1 + b * (-0.5f + b * (1 / 24.0f + b * (-1 / 720.0f + b * (1 / 40320.0f))))};
}

// The same for x in [0, 1].
inline SinCos sin_cos_whole_turn(float x) {
  const int quarter = static_cast<int>(4 * x + 0.5f);  // the nearest, 0 to 4
  const SinCos t = sin_cos_turn(x - 0.25f * static_cast<float>(quarter));
  switch (quarter & 3) {
    case 0:
      return t;
    case 1:
      return {t.cos, -t.sin};
    case 2:
      return {-t.sin, -t.cos};
    default:
      return {-t.cos, t.sin};
  }
}

// The unit square onto the unit disk; neighbours stay neighbours (Shirley and Chiu, "A low
// distortion map between disk and square", 1997).
inline Vec2f concentric_disk(Vec2f square) {
  const float a = 2 * square.x - 1, b = 2 * square.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  if (std::fabs(a) > std::fabs(b)) {
    const SinCos t = sin_cos_turn(b / a * 0.125f);
    return {a * t.cos, a * t.sin};
  }
  const SinCos t = sin_cos_turn(a / b * 0.125f);
  return {b * t.sin, b * t.cos};
}

// Two unit vectors that are perpendicular to `n` and to each other (Duff et al., "Building an
// orthonormal basis, revisited", JCGT 6(1), 2017). Requires: n is of unit length.
struct Basis {
  Vec3f tangent, bitangent;
};
inline Basis basis_about(Vec3f n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

// Of pdf cosine / pi about `normal`.
inline Vec3f cosine_direction(Vec3f normal, Vec2f square) {
  const Vec2f disk = concentric_disk(square);
  const float height = std::sqrt(std::fmax(0.0f, 1 - disk.x * disk.x - disk.y * disk.y));
  const Basis basis = basis_about(normal);
  return basis.tangent * disk.x + basis.bitangent * disk.y + normal * height;
}

}  // namespace tessera::core
