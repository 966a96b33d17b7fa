// SPDX-License-Identifier: Apache-2.0
// Colours of vertices, as programs write them into OBJ and PLY files: shares of what a display
// shows.
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/vec3.h"

namespace tessera {

// sRGB (IEC 61966-2-1) to linear; what is beyond [0, 1] is cut off there. Requires: not NaN.
inline float linear_of_srgb(float value) {
  const float v = std::clamp(value, 0.0f, 1.0f);
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

inline Vec4f vertex_color(float r, float g, float b, float alpha) {
  return {linear_of_srgb(r), linear_of_srgb(g), linear_of_srgb(b), std::clamp(alpha, 0.0f, 1.0f)};
}

}  // namespace tessera
