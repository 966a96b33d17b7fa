// SPDX-License-Identifier: Apache-2.0
// A pinhole camera. Pixel (x, y) has its centre at (x + 0.5, y + 0.5), row 0 on top.
// Threads. Plain values. Handed to slaves as it is: all of them derive the same rays from it.
#pragma once

#include "common/math/vec3.h"

namespace tessera {

// Requires (validate_camera): all finite, eye != target, up not parallel to target - eye,
// 0 < vfov_degrees < 180.
struct Camera {
  Vec3f eye{0, 0, 5};
  Vec3f target{0, 0, 0};
  Vec3f up{0, 1, 0};
  float vfov_degrees = 45;  // vertical opening angle
  bool operator==(const Camera&) const = default;
};

}  // namespace tessera
