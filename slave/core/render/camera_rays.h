// Rays of a pinhole camera. Computed in double from the camera's floats and rounded once, so that a
// ray is off by no more than one rounding per component; no library sine or tangent, whose last
// bits depend on the processor it runs on.
#pragma once

#include "common/math/vec3.h"
#include "common/scene/camera.h"

namespace tessera::core {

class CameraRays {
 public:
  // Requires: validate_camera(camera) is ok; sizes at least 1.
  CameraRays(const Camera& camera, int width_px, int height_px);

  Vec3f origin() const { return origin_; }
  // Direction through the image point (x, y), pixels from the top left corner; its length is not 1.
  Vec3f direction(double x, double y) const {
    return {static_cast<float>(corner_.x + x * per_x_.x + y * per_y_.x),
            static_cast<float>(corner_.y + x * per_x_.y + y * per_y_.y),
            static_cast<float>(corner_.z + x * per_x_.z + y * per_y_.z)};
  }
  // Edge of a pixel at distance 1, in the middle of the picture.
  float pixel_spread() const { return pixel_spread_; }

 private:
  struct Vec3d {
    double x, y, z;
  };
  Vec3f origin_;
  float pixel_spread_;
  Vec3d corner_, per_x_, per_y_;  // direction = corner + x per_x + y per_y
};

}  // namespace tessera::core
