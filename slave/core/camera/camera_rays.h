// SPDX-License-Identifier: Apache-2.0
// Rays of a pinhole camera. They are computed in double from the camera's floats and rounded once,
// so that a ray is off by no more than one rounding per component. No library sine or tangent is
// used: their last bits depend on the processor that they run on.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "common/math/vec3.h"
#include "common/scene/camera.h"
#include "slave/core/camera/camera-inl.h"
#include "slave/core/camera/camera_layout.h"

namespace tessera::core {

class CameraRays {
 public:
  // Requires: validate_camera(camera) is ok; sizes at least 1.
  CameraRays(const Camera& camera, int width_px, int height_px);

  Vec3f origin() const { return origin_; }
  // Direction through the image point (x, y), pixels from the top left corner; its length is not 1.
  Vec3f direction(double x, double y) const {
    const auto along = [&](int axis) { return plain::camera_direction(view_, axis, x, y); };
    return {along(0), along(1), along(2)};
  }
  const CameraView& view() const { return view_; }
  // Edge of a pixel at distance 1, in the middle of the picture.
  float pixel_spread() const { return pixel_spread_; }

 private:
  Vec3f origin_;
  float pixel_spread_;
  CameraView view_;
};

}  // namespace tessera::core
