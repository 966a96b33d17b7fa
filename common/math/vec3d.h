// SPDX-License-Identifier: Apache-2.0
// Three doubles: for what is computed once in a frame or a scene and rounded to Vec3f at the end.
// Threads. Plain values.
#pragma once

#include "common/math/vec3.h"

namespace tessera {

using Vec3d = Vec3<double>;

inline Vec3d widened(Vec3f a) { return {a.x, a.y, a.z}; }
inline Vec3f rounded(Vec3d a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

}  // namespace tessera
