// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/framing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera {
namespace {

// Eye and target must differ after rounding to float, and their difference must keep a direction:
// 2^-24 of the coordinate for each rounding, and eleven bits for the direction.
constexpr double kNearOfCoordinate = 1.0 / (1 << 13);
// Squares of a camera's distance are normal floats between these.
constexpr double kTargetDistanceMin = 0x1p-60, kTargetDistanceMax = 0x1p60;
// Each step of centre() is one of Newton's on a convex piecewise linear function from the left,
// which ends at the root after as many steps as pieces are met; seven were the most ever seen.
constexpr int kCentreStepsMax = 32;

double greatest_coordinate(Vec3d a) {
  return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

// Questions of framing to the map, in the camera's axes.
struct Silhouette {
  const SupportMap& map;
  Vec3d ahead, right, above;

  Silhouette(const SupportMap& scene_map, Vec3d view, Vec3d up)
      : map(scene_map),
        ahead(normalize(view)),
        right(normalize(cross(ahead, normalize(up)))),
        above(cross(right, ahead)) {}

  double height(Vec3d normal) const { return dot(normal, map.farthest(normal)); }

  // An eye at depth e and place c across sees the vertices within |across - c| <= k (depth - e).
  // So c >= h(across - k ahead) + k e and -c >= h(-across - k ahead) + k e, h being the farthest
  // vertex's height along a normal; there is such a c as long as the sum of the right sides is not
  // positive. Returns: the greatest e.
  double depth_limit(Vec3d across, double k) const {
    return -(height(across - k * ahead) + height(-across - k * ahead)) / (2 * k);
  }

  // The place across of an eye at that depth for which the vertices' projection reaches as far to
  // one side as to the other: the smallest k of depth_limit() whose two constraints can be met,
  // found as the root of a maximum of ratios (W. Dinkelbach, "On Nonlinear Fractional Programming",
  // 1967), and the c that meets both.
  double centre(Vec3d across, double depth) const {
    double k = 0, place = 0;
    for (int i = 0; i < kCentreStepsMax; ++i) {
      const Vec3d p = map.farthest(across - k * ahead), q = map.farthest(-across - k * ahead);
      const double p_depth = dot(p, ahead) - depth, q_depth = dot(q, ahead) - depth;
      const double next = (dot(p, across) - dot(q, across)) / (p_depth + q_depth);
      if (i > 0 && !(next > k)) break;
      k = next;
      place = 0.5 * (dot(p, across) - k * p_depth + dot(q, across) + k * q_depth);
    }
    return place;
  }
};

}  // namespace

Camera framed_camera(const SupportMap& map, const Framing& framing) {
  const Silhouette shape(map, framing.view, framing.up);
  const double k_above = kFramedShare * std::tan(framing.vfov_degrees * std::numbers::pi / 360);
  const double k_right = k_above * framing.aspect;
  const double nearest = -shape.height(-shape.ahead), farthest = shape.height(shape.ahead);
  const double extent = std::max(shape.height(shape.right) + shape.height(-shape.right),
                                 shape.height(shape.above) + shape.height(-shape.above));
  const Bounds3f box = map.bounds();
  const double coordinate =
      std::max(greatest_coordinate(widened(box.lower)), greatest_coordinate(widened(box.upper)));
  const double near_min = std::max(kNearOfCoordinate * coordinate, extent > 0 ? 0.0 : 1.0);
  const double depth = std::min({shape.depth_limit(shape.right, k_right),
                                 shape.depth_limit(shape.above, k_above), nearest - near_min});
  const Vec3d eye = shape.centre(shape.right, depth) * shape.right +
                    shape.centre(shape.above, depth) * shape.above + depth * shape.ahead;
  const double distance =
      std::clamp(0.5 * (nearest + farthest) - depth, kTargetDistanceMin, kTargetDistanceMax);
  Camera camera;
  camera.eye = rounded(eye);
  camera.target = rounded(eye + distance * shape.ahead);
  camera.up = rounded(framing.up);
  camera.vfov_degrees = static_cast<float>(framing.vfov_degrees);
  return camera;
}

}  // namespace tessera
