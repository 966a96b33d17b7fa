// SPDX-License-Identifier: Apache-2.0
// Turns input events into camera motion: orbit, pan, zoom, fly; and keys into commands for the
// viewer (key_map.h).
//
// The camera is held as a target, a distance and two angles around the up vector of the first
// camera ("home"): orbiting cannot change the distance, panning cannot change the direction, and
// the polar angle is bounded away from both poles, so that the picture never flips.
//
// Threads. One owner (the viewer's main thread).
//
// Invariants. camera() satisfies validate_camera() and has home's up vector and opening angle.
// Before the first motion, and after kReset, it is home to the bit. revision() counts up exactly
// when camera() changed.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "common/math/bounds3.h"
#include "common/scene/camera.h"
#include "master/display/input_event.h"
#include "master/display/key_map.h"

namespace tessera::master {

// The camera that shows all of the scene to a person who sees it with `seen`. aspect: the picture's
// width / height.
using CameraOfAll = std::function<Camera(const Camera& seen, double aspect)>;

class CameraControls {
 public:
  // Requires: home is valid. Empty or non-finite bounds: home's distance stands for the size of the
  // scene.
  CameraControls(const Camera& home, const Bounds3f& bounds);

  // The framebuffer's size, by which drags are scaled. Pixels, at least 1 each.
  void set_viewport(int width_px, int height_px);

  // Sets the camera that key f shows; without it, that is the sphere around the bounds. Only its
  // eye and target count: home's up vector and opening angle are kept.
  void set_camera_of_all(CameraOfAll camera_of_all) { camera_of_all_ = std::move(camera_of_all); }

  // Returns: what is left for the viewer to do.
  ViewerCommand handle(const InputEvent& event);

  // Flies on while fly keys are down. seconds: since the last call; more than kStepSecondsMax
  // counts as kStepSecondsMax, so that a stall does not become a leap.
  void advance(double seconds);
  bool is_flying() const;
  bool is_dragging() const { return drag_ != Drag::kNone; }

  const Camera& camera() const { return camera_; }
  std::uint64_t revision() const { return revision_; }

  static constexpr double kStepSecondsMax = 0.1;

 private:
  struct Vec3d {
    double x = 0, y = 0, z = 0;
  };
  enum class Drag { kNone, kOrbit, kPan };
  static constexpr int kFlyKeyCount = 6;  // w a s d q e

  static Vec3d add(Vec3d a, Vec3d b, double scale);  // a + b * scale
  void adopt(const Camera& camera);                  // angles, distance and target from a camera
  Vec3d offset_direction() const;                    // unit, from target to eye
  Vec3d right() const;                               // unit
  void orbit(double dx_px, double dy_px);
  void pan(double dx_px, double dy_px);
  void zoom(double steps);
  void fit();
  void move_target(Vec3d direction, double distance);
  void compose();  // sets camera_ from the state
  ViewerCommand handle_key(const InputEvent& event);

  Camera home_;
  Camera camera_;
  CameraOfAll camera_of_all_;
  std::uint64_t revision_ = 0;

  double scene_size_ = 1;  // diagonal of the scene's box
  Vec3d scene_centre_;
  bool has_bounds_ = false;
  Vec3d up_, side_, front_;  // the orthonormal frame of the angles
  Vec3d target_;
  double distance_ = 1;  // eye to target, in [distance_min_, distance_max_]
  double azimuth_ = 0;   // radians, around up_, from front_ towards side_
  double polar_ = 1.5;   // radians between up_ and offset, in [polar_min_, polar_max_]
  double distance_min_ = 0, distance_max_ = 1;
  double polar_min_ = 0, polar_max_ = 3;

  int width_px_ = 640, height_px_ = 480;
  double x_px_ = 0, y_px_ = 0;
  bool has_position_ = false;
  Drag drag_ = Drag::kNone;
  MouseButton drag_button_ = MouseButton::kOther;
  std::array<bool, kFlyKeyCount> is_down_{};
  bool is_fast_ = false;
};

}  // namespace tessera::master
