// SPDX-License-Identifier: Apache-2.0
// Directions about a normal, for plain numbers, by the text of hemisphere-inl.h.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "common/math/vec3.h"
#include "slave/core/sampling/hemisphere-inl.h"

namespace tessera::core {

using plain::Basis;
using plain::basis_about;
using plain::sin_cos_turn;
using plain::sin_cos_whole_turn;
using plain::SinCos;

inline Vec2f concentric_disk(Vec2f square) {
  const auto disk = plain::concentric_disk(square.x, square.y);
  return {disk.x, disk.y};
}

inline Vec3f cosine_direction(Vec3f normal, Vec2f square) {
  return plain::cosine_direction(normal, square.x, square.y);
}

}  // namespace tessera::core
