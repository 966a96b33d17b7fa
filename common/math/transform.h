// SPDX-License-Identifier: Apache-2.0
// Affine map of points: p -> M p + t. Rows of M are stored; the fourth column is t.
// Threads. Plain values. Points, directions and normals are mapped by different members; which one
// a vector is stands at the call.
#pragma once

#include <array>

#include "common/math/vec3.h"

namespace tessera {

struct Transform {
  // m[row][column]; column 3 is the translation.
  std::array<std::array<float, 4>, 3> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  bool operator==(const Transform&) const = default;

  Vec3f point(Vec3f p) const {
    return {m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
            m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
            m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
  }
  Vec3f direction(Vec3f d) const {
    return {m[0][0] * d.x + m[0][1] * d.y + m[0][2] * d.z,
            m[1][0] * d.x + m[1][1] * d.y + m[1][2] * d.z,
            m[2][0] * d.x + m[2][1] * d.y + m[2][2] * d.z};
  }
  // Maps a normal: cofactor matrix times n, so that it needs no inverse and survives scaling.
  // Not normalised; flips with the determinant's sign.
  Vec3f normal(Vec3f n) const {
    const auto [c0, c1, c2] = cofactors();
    return {dot(c0, n), dot(c1, n), dot(c2, n)};
  }
  // Rows of the cofactor matrix of M.
  std::array<Vec3f, 3> cofactors() const {
    const Vec3f r0{m[0][0], m[0][1], m[0][2]}, r1{m[1][0], m[1][1], m[1][2]},
        r2{m[2][0], m[2][1], m[2][2]};
    return {cross(r1, r2), cross(r2, r0), cross(r0, r1)};
  }
  bool is_identity() const { return *this == Transform{}; }
};

// (a * b)(p) = a(b(p)).
inline Transform operator*(const Transform& a, const Transform& b) {
  Transform r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      r.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j] +
                  (j == 3 ? a.m[i][3] : 0);
    }
  }
  return r;
}

}  // namespace tessera
