// SPDX-License-Identifier: Apache-2.0
// Vec3f has three floats for points, directions and RGB radiance, laid out as x, y, z (12 bytes).
// Vec2f is for texture coordinates, Vec4f for tangents and colours with alpha, which are only
// stored.
// Threads. Plain values.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/real.h"

namespace tessera {

struct Vec2f {
  float x = 0, y = 0;
  bool operator==(const Vec2f&) const = default;
};

struct Vec4f {
  float x = 0, y = 0, z = 0, w = 0;
  bool operator==(const Vec4f&) const = default;
};
static_assert(sizeof(Vec4f) == 16);

#define TESSERA_VEC3_INLINE inline
#include "common/math/vec3_text.h"
#undef TESSERA_VEC3_INLINE

using Vec3f = Vec3<float>;
static_assert(sizeof(Vec3f) == 12);

// Functions of vec3_text.h, declared again so that they take arguments in braces.
inline float dot(Vec3f a, Vec3f b);
inline Vec3f cross(Vec3f a, Vec3f b);
inline float length(Vec3f a);
inline Vec3f normalize(Vec3f a);

template <class T>
constexpr bool operator==(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
inline Vec3f min(Vec3f a, Vec3f b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec3f max(Vec3f a, Vec3f b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
inline bool is_finite(Vec2f a) { return std::isfinite(a.x) && std::isfinite(a.y); }
inline bool is_finite(const Vec4f& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z) && std::isfinite(a.w);
}
// Whether a colour has no light; a NaN component counts as none.
inline bool is_black(Vec3f c) { return !(c.x > 0 || c.y > 0 || c.z > 0); }
inline bool is_finite(Vec3f a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace tessera
