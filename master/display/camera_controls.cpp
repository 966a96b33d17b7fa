// SPDX-License-Identifier: Apache-2.0
#include "master/display/camera_controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::master {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPoleRadians = kPi / 180;  // orbiting stops one degree before the up vector
constexpr double kZoomPerStep = 0.9;        // distance factor of one wheel step
constexpr double kScrollStepsMax = 100;     // of one event; more is a broken device
constexpr double kFlySizesPerSecond = 0.4;  // scene diagonals
constexpr double kFlyFastFactor = 4;
constexpr double kNearSizes = 1e-3, kFarSizes = 100;  // bounds of the distance, scene diagonals
constexpr double kReachSizes = 1000;  // how far the target may leave the scene's centre
// Eye and target must differ after rounding to float, and so must their parts at right angles to
// up, which near the pole are sin(1 degree) = 2^-5.8 of the distance apart. Two roundings of 2^-24
// of the coordinate, and four bits for the direction, make a distance of 2^-13.2 of the coordinate.
constexpr double kNearOfCoordinate = 1.0 / (1 << 13);

int fly_slot(Key key) {
  switch (key) {
    case Key::kW:
      return 0;
    case Key::kS:
      return 1;
    case Key::kD:
      return 2;
    case Key::kA:
      return 3;
    case Key::kE:
      return 4;
    case Key::kQ:
      return 5;
    default:
      return -1;
  }
}

template <typename V>
double dot3(V a, V b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename V>
V cross3(V a, V b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename V>
V unit3(V a) {
  const double l = std::sqrt(dot3(a, a));
  return {a.x / l, a.y / l, a.z / l};
}

template <typename V>
V wide(Vec3f a) {
  return {double{a.x}, double{a.y}, double{a.z}};
}

template <typename V>
Vec3f narrow(V a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

template <typename V>
double greatest_coordinate(V a) {
  return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

}  // namespace

CameraControls::Vec3d CameraControls::add(Vec3d a, Vec3d b, double scale) {
  return {a.x + b.x * scale, a.y + b.y * scale, a.z + b.z * scale};
}

CameraControls::CameraControls(const Camera& home, const Bounds3f& bounds)
    : home_(home), camera_(home) {
  const Vec3d eye = wide<Vec3d>(home.eye), target = wide<Vec3d>(home.target);
  const Vec3d offset = add(eye, target, -1);
  const double home_distance = std::sqrt(dot3(offset, offset));
  scene_size_ = home_distance;
  scene_centre_ = target;
  if (!bounds.is_empty() && is_finite(bounds.lower) && is_finite(bounds.upper)) {
    const Vec3d lower = wide<Vec3d>(bounds.lower), upper = wide<Vec3d>(bounds.upper);
    const Vec3d extent = add(upper, lower, -1);
    if (const double diagonal = std::sqrt(dot3(extent, extent)); diagonal > 0) {
      scene_size_ = diagonal;
      scene_centre_ = add(lower, extent, 0.5);
      has_bounds_ = true;
    }
  }
  up_ = unit3(wide<Vec3d>(home.up));
  front_ = unit3(add(offset, up_, -dot3(offset, up_)));
  side_ = cross3(up_, front_);
  adopt(home);
  // Home may stand nearer, farther or steeper than the bounds would let a person go; then home is
  // the bound.
  distance_min_ = std::min(kNearSizes * scene_size_, home_distance);
  distance_max_ = std::max(kFarSizes * scene_size_, home_distance);
  polar_min_ = std::min(kPoleRadians, polar_);
  polar_max_ = std::max(kPi - kPoleRadians, polar_);
}

void CameraControls::adopt(const Camera& camera) {
  target_ = wide<Vec3d>(camera.target);
  const Vec3d offset = add(wide<Vec3d>(camera.eye), target_, -1);
  distance_ = std::sqrt(dot3(offset, offset));
  const Vec3d direction = unit3(offset);
  azimuth_ = std::atan2(dot3(direction, side_), dot3(direction, front_));
  polar_ = std::acos(std::clamp(dot3(direction, up_), -1.0, 1.0));
}

void CameraControls::set_viewport(int width_px, int height_px) {
  width_px_ = std::max(1, width_px);
  height_px_ = std::max(1, height_px);
}

CameraControls::Vec3d CameraControls::offset_direction() const {
  const double level = std::sin(polar_);
  Vec3d v = add({}, up_, std::cos(polar_));
  v = add(v, front_, level * std::cos(azimuth_));
  return add(v, side_, level * std::sin(azimuth_));
}

// The offset after a quarter turn around up, which is forward x up.
CameraControls::Vec3d CameraControls::right() const {
  return add(add({}, front_, -std::sin(azimuth_)), side_, std::cos(azimuth_));
}

void CameraControls::compose() {
  // Rounding to float must leave eye and target apart, wherever the target is.
  distance_ = std::clamp(distance_, distance_min_, distance_max_);
  const double distance = std::max(distance_, greatest_coordinate(target_) * kNearOfCoordinate);
  Camera next = home_;
  next.target = narrow(target_);
  next.eye = narrow(add(target_, offset_direction(), distance));
  if (next == camera_ || !is_finite(next.eye))
    return;  // the camera stands still where a float's range ends
  camera_ = next;
  ++revision_;
}

// A drag over the shorter side is half a turn; the scene follows the mouse.
void CameraControls::orbit(double dx_px, double dy_px) {
  const double radians_per_px = kPi / std::min(width_px_, height_px_);
  azimuth_ = std::remainder(azimuth_ - dx_px * radians_per_px, 2 * kPi);
  polar_ = std::clamp(polar_ - dy_px * radians_per_px, polar_min_, polar_max_);
  compose();
}

// The point of the target plane under the mouse stays under it.
void CameraControls::pan(double dx_px, double dy_px) {
  const double per_px = 2 * distance_ * std::tan(home_.vfov_degrees * kPi / 360) / height_px_;
  const Vec3d camera_up = cross3(offset_direction(), right());
  move_target(right(), -dx_px * per_px);
  move_target(camera_up, dy_px * per_px);
  compose();
}

void CameraControls::zoom(double steps) {
  distance_ *= std::pow(kZoomPerStep, std::clamp(steps, -kScrollStepsMax, kScrollStepsMax));
  compose();
}

// Without camera_of_all_, the sphere around the scene's box fits into the narrower opening angle.
void CameraControls::fit() {
  if (camera_of_all_) {
    adopt(camera_of_all_(camera_, double(width_px_) / height_px_));
    polar_ = std::clamp(polar_, polar_min_, polar_max_);
  } else if (has_bounds_) {
    const double tan_vertical = std::tan(home_.vfov_degrees * kPi / 360);
    const double tan_narrow = tan_vertical * std::min(1.0, double(width_px_) / height_px_);
    target_ = scene_centre_;
    distance_ = scene_size_ / 2 / std::sin(std::atan(tan_narrow));
  } else {
    adopt(home_);
  }
  compose();
}

void CameraControls::move_target(Vec3d direction, double distance) {
  const Vec3d moved = add(target_, direction, distance);
  const Vec3d before = add(target_, scene_centre_, -1), after = add(moved, scene_centre_, -1);
  const double reach = std::max(kReachSizes * scene_size_, std::sqrt(dot3(before, before)));
  if (std::sqrt(dot3(after, after)) <= reach) target_ = moved;  // NaN does not pass
}

bool CameraControls::is_flying() const {
  return std::any_of(is_down_.begin(), is_down_.end(), [](bool is_down) { return is_down; });
}

void CameraControls::advance(double seconds) {
  if (!is_flying() || !(seconds > 0)) return;
  const double step = std::min(seconds, kStepSecondsMax) * kFlySizesPerSecond * scene_size_ *
                      (is_fast_ ? kFlyFastFactor : 1);
  const auto sign = [this](std::size_t plus) {
    return double(is_down_[plus]) - double(is_down_[plus + 1]);
  };
  move_target(offset_direction(), -step * sign(0));
  move_target(right(), step * sign(2));
  move_target(up_, step * sign(4));
  compose();
}

ViewerCommand CameraControls::handle_key(const InputEvent& event) {
  if (const int slot = fly_slot(event.key); slot >= 0 && !event.has_control)
    is_down_[static_cast<std::size_t>(slot)] = true;
  const ViewerCommand command = command_of(event.key, event.has_control);
  if (command == ViewerCommand::kFitScene) {
    fit();
  } else if (command == ViewerCommand::kResetCamera) {
    adopt(home_);
    if (!(camera_ == home_)) {
      camera_ = home_;
      ++revision_;
    }
  } else {
    return command;
  }
  return ViewerCommand::kNone;
}

ViewerCommand CameraControls::handle(const InputEvent& event) {
  using Kind = InputEvent::Kind;
  switch (event.kind) {
    case Kind::kKeyDown:
      is_fast_ = event.has_shift;
      return handle_key(event);
    case Kind::kKeyUp:
      is_fast_ = event.has_shift;
      if (const int slot = fly_slot(event.key); slot >= 0)
        is_down_[static_cast<std::size_t>(slot)] = false;
      break;
    case Kind::kButtonDown:
      if (drag_ != Drag::kNone || event.button == MouseButton::kOther) break;
      drag_ = event.button == MouseButton::kMiddle || event.has_shift ? Drag::kPan : Drag::kOrbit;
      drag_button_ = event.button;
      break;
    case Kind::kButtonUp:
      if (event.button == drag_button_) drag_ = Drag::kNone;
      break;
    case Kind::kMove: {
      const double dx_px = event.x_px - x_px_, dy_px = event.y_px - y_px_;
      const bool has_delta = has_position_;
      x_px_ = event.x_px;
      y_px_ = event.y_px;
      has_position_ = true;
      if (has_delta && drag_ == Drag::kOrbit) orbit(dx_px, dy_px);
      if (has_delta && drag_ == Drag::kPan) pan(dx_px, dy_px);
      break;
    }
    case Kind::kScroll:
      zoom(event.scroll_steps);
      break;
    case Kind::kFocusLost:
      is_down_.fill(false);
      is_fast_ = false;
      drag_ = Drag::kNone;
      break;
  }
  return ViewerCommand::kNone;
}

}  // namespace tessera::master
