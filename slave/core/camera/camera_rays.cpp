// SPDX-License-Identifier: Apache-2.0
#include "slave/core/camera/camera_rays.h"

#include "common/math/vec3d.h"

namespace tessera::core {
namespace {

// tan(x) for 0 < x < pi / 2 from the Taylor series of sine and cosine. The terms end at x^31 / 31!,
// below 2e-28 there; what is left is the rounding of some 16 additions in double.
double tangent(double x) {
  double sine = 0, cosine = 0, term = 1;
  for (int n = 0; n < 32; ++n) {
    const double sign = (n / 2) % 2 == 0 ? 1 : -1;
    (n % 2 == 0 ? cosine : sine) += sign * term;
    term *= x / (n + 1);
  }
  return sine / cosine;
}

}  // namespace

CameraRays::CameraRays(const Camera& camera, int width_px, int height_px) : origin_(camera.eye) {
  const auto unit = [](Vec3d a) {
    const double l = length(a);
    return Vec3d{a.x / l, a.y / l, a.z / l};
  };
  const Vec3d forward = unit(widened(camera.target) - widened(camera.eye));
  const Vec3d right = unit(cross(forward, unit(widened(camera.up))));
  const Vec3d up = cross(right, forward);
  constexpr double kPi = 3.14159265358979323846;
  const double half_height = tangent(double{camera.vfov_degrees} * (kPi / 360));
  const double pixel = 2 * half_height / height_px;  // edge of a pixel at distance 1
  pixel_spread_ = static_cast<float>(pixel);
  const double half_width = pixel * width_px / 2;
  view_ = {{forward.x - right.x * half_width + up.x * half_height,
            forward.y - right.y * half_width + up.y * half_height,
            forward.z - right.z * half_width + up.z * half_height},
           {right.x * pixel, right.y * pixel, right.z * pixel},
           {-up.x * pixel, -up.y * pixel, -up.z * pixel}};
}

}  // namespace tessera::core
