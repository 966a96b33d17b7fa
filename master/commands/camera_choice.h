// SPDX-License-Identifier: Apache-2.0
// Which camera a command starts with: what --camera says, else the scene's own, else one that shows
// the scene (common/viewpoint).
//
// --camera is a camera's text, a camera file, or a number or name among the scene file's cameras,
// tried in this order: a file of that name wins, then a number from 1.
//
// Threads. One at a time.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "common/scene_io/camera_file.h"
#include "master/commands/options.h"

namespace tessera::master {

class CameraChoice {
 public:
  // Called before the scene is read, which may take minutes. Returns: what is wrong with a camera
  // file.
  static Result<CameraChoice> read(const MasterOptions& options);

  // The picture size that a camera file gives, if it has one.
  std::optional<ImageSize> size() const { return path_ ? path_->size() : std::nullopt; }

  // Settles the camera. Returns: one line that lists the scene's cameras, when --camera names none.
  Status settle(const Scene& scene, int width_px, int height_px);

  // The camera of one frame. Requires: settle() was called.
  Camera at(double frame) const { return path_ ? path_->at(frame) : camera_; }
  bool is_from_viewpoint() const { return is_from_viewpoint_; }  // nobody gave one
  // Which of the cameras of the scene that settle() was given it is, if it is one of them.
  std::optional<std::size_t> number_in(const Scene& scene) const;

  // The point that --orbit turns the camera about: the eye itself within a room, else the point on
  // the line of sight that is next to the middle of the scene, if that lies ahead.
  Vec3f orbit_centre(const Scene& scene) const;

 private:
  std::string text_;  // --camera
  std::optional<Camera> inline_camera_;
  std::optional<CameraPath> path_;
  Camera camera_;
  bool is_from_viewpoint_ = false;
  bool is_inside_ = false;
};

// The camera that key f of the window asks for, which sees the whole scene. The function looks at
// the scene when it is first called. One thread.
std::function<Camera(const Camera& seen, double aspect)> camera_of_all(const Scene& scene);

}  // namespace tessera::master
