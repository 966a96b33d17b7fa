// SPDX-License-Identifier: Apache-2.0
// Vectors of a packet, kept by axis for the kernels.
// Threads. Pure functions.
#pragma once

#include <cstddef>

#include "common/math/vec3.h"

namespace tessera::core {

template <std::size_t kCount>
Vec3f vector_at(const float (&v)[3][kCount], int i) {
  return {v[0][i], v[1][i], v[2][i]};
}
template <std::size_t kCount>
void put_vector(Vec3f v, float (&to)[3][kCount], int i) {
  to[0][i] = v.x;
  to[1][i] = v.y;
  to[2][i] = v.z;
}

}  // namespace tessera::core
