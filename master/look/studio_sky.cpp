// SPDX-License-Identifier: Apache-2.0
#include "master/look/studio_sky.h"

#include <algorithm>
#include <cmath>

namespace tessera::master {
namespace {

constexpr int kWidthPx = 256, kHeightPx = 128;  // 1.4 degrees: every edge is softer than that
constexpr double kPi = 3.14159265358979323846;

double radians(double degrees) { return degrees * kPi / 180; }

double smooth(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// A lamp on the sky: half-extents to its edge, all angles in degrees; edges fade over `fade`.
struct SoftBox {
  double azimuth, elevation, half_width, half_height, fade, radiance;

  // Radiance from a direction. Its azimuth counts from the viewer's and rises to the viewer's left.
  double at(double of_azimuth, double of_elevation) const {
    double aside = std::remainder(of_azimuth - azimuth, 360.0);
    aside *= std::cos(radians(of_elevation));  // as wide at every elevation
    const double x = std::fabs(aside) - half_width;
    const double y = std::fabs(of_elevation - elevation) - half_height;
    const double out = std::max(x, y) > 0 ? std::hypot(std::max(x, 0.0), std::max(y, 0.0)) : 0;
    return radiance * (1 - smooth(0, fade, out));
  }
};

constexpr SoftBox kBoxes[] = {
    {45, 40, 17, 17, 9, 3.8},    // key
    {-120, 30, 5, 26, 7, 3.4},   // rim
    {-55, 15, 14, 22, 14, 0.4},  // fill
};

// The sky without lamps: brightest above the horizon, darker overhead, a grey floor below.
double plain_sky(double elevation) {
  const double sky = 0.52 - 0.26 * smooth(0, 90, elevation);
  const double floor = 0.22 - 0.10 * smooth(0, 90, -elevation);
  return floor + (sky - floor) * smooth(-4, 4, elevation);
}

double studio_radiance(double azimuth, double elevation) {
  double sum = plain_sky(elevation);
  for (const SoftBox& box : kBoxes) sum += box.at(azimuth, elevation);
  return sum;
}

}  // namespace

std::shared_ptr<const EnvironmentMap> make_studio_sky(Vec3f towards_viewer) {
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = kWidthPx;
  map->height_px = kHeightPx;
  // The map's angle is 0 in the middle, at -z, and rises towards +x. Seen from the camera, which
  // looks from its own angle inwards, rising angles go to the left.
  const double viewer = std::atan2(double{towards_viewer.x}, -double{towards_viewer.z});
  for (int row = 0; row < kHeightPx; ++row) {
    const double elevation = 90 - 180.0 * (row + 0.5) / kHeightPx;
    for (int column = 0; column < kWidthPx; ++column) {
      const double angle = 2 * kPi * ((column + 0.5) / kWidthPx - 0.5);
      const double azimuth = (angle - viewer) * 180 / kPi;
      const auto radiance = static_cast<float>(studio_radiance(azimuth, elevation));
      for (int c = 0; c < 3; ++c) map->rgb.push_back(radiance);
    }
  }
  return map;
}

}  // namespace tessera::master
