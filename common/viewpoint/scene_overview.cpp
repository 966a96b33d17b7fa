// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/scene_overview.h"

#include <algorithm>

#include "common/viewpoint/patch_net.h"

namespace tessera {
namespace {

// How far the view goes aside and down for one unit ahead.
constexpr double kAside = 0.55, kDown = 0.42;

Vec3d along(Axis axis) {
  const double sign = static_cast<int>(axis) % 2 == 0 ? 1 : -1;
  const int dimension = static_cast<int>(axis) / 2;
  return {dimension == 0 ? sign : 0, dimension == 1 ? sign : 0, dimension == 2 ? sign : 0};
}

}  // namespace

SceneOverview::SceneOverview(const Scene& scene) : map_(scene), bounds_(map_.bounds()) {
  const Scene meshes = with_meshes_for_surfaces(scene);
  const AxisRays rays(meshes, bounds_);
  evidence_ = evidence_of(rays);
  if (!evidence_.is_interior()) return;
  places_ = eye_places(rays);
  measure_sights(meshes, places_);
}

Camera SceneOverview::default_camera(double aspect) const {
  if (map_.is_empty()) return {};
  if (is_inside()) return inside_camera(places_, kInsideVfovDegrees, aspect);
  Framing framing;
  const Vec3d ahead = along(evidence_.view()), up{0, 1, 0};
  framing.view = places_.empty() ? ahead - kAside * cross(ahead, up) - kDown * up : ahead;
  framing.aspect = aspect;
  return framed_camera(map_, framing);
}

Camera SceneOverview::camera_of_all(const Camera& seen, double aspect) const {
  if (map_.is_empty()) return seen;
  if (!places_.empty() && !stands_before_open_side(seen.eye)) {
    Camera camera = inside_camera(places_, seen.vfov_degrees, aspect);
    const Vec3d view = widened(camera.target) - widened(camera.eye);
    const Vec3d level = cross(normalize(view), normalize(widened(seen.up)));
    if (length(level) > 0.1) camera.up = seen.up;
    return camera;
  }
  Framing framing;
  framing.view = widened(seen.target) - widened(seen.eye);
  framing.up = widened(seen.up);
  framing.vfov_degrees = seen.vfov_degrees;
  framing.aspect = aspect;
  return framed_camera(map_, framing);
}

// Of the sides that the eye is beyond, the one that counts is that from which it is farthest.
bool SceneOverview::stands_before_open_side(Vec3f eye) const {
  Axis side = Axis::kAhead;
  double farthest = 0;
  for (const Axis axis : kAxes) {
    const auto way = static_cast<int>(axis), along = way / 2;
    const double beyond = way % 2 == 0 ? double{bounds_.lower[along]} - eye[along]
                                       : double{eye[along]} - bounds_.upper[along];
    if (!(beyond > farthest)) continue;
    farthest = beyond;
    side = axis;
  }
  return farthest > 0 && evidence_.is_open(side);
}

Camera default_camera(const Scene& scene, int width_px, int height_px) {
  return SceneOverview(scene).default_camera(double(width_px) / height_px);
}

}  // namespace tessera
