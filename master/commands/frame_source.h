// SPDX-License-Identifier: Apache-2.0
// What to render: the scene of the command line with its camera path, frame by frame. Shared by
// view and render.
//
// Threads. One at a time.
#pragma once

#include <functional>
#include <optional>

#include "common/base/signal_watch.h"
#include "master/commands/camera_choice.h"
#include "master/commands/options.h"
#include "master/commands/progress.h"
#include "master/loader/load_scene.h"
#include "master/look/first_look.h"

namespace tessera::master {

class FrameSource {
 public:
  // Loads the scene (with progress, until a signal) and the camera; warnings go to stderr, a line
  // each.
  // Returns: kInvalidArgument for a camera that cannot be, else the loader's refusal.
  static Result<FrameSource> open(const MasterOptions& options, Progress& progress,
                                  const SignalWatch& signals);

  const LoadedScene& loaded() const { return loaded_; }
  // Shows another scene with the camera, light and exposure that were settled for the first one.
  void replace(LoadedScene loaded);
  bool is_animated() const { return loaded_.is_animated; }
  // Whether the scene is one for all frames, and moves with their time.
  bool is_timed() const { return loaded_.scene.animation != nullptr; }
  // After which the scene begins again: 0 where nothing moves, infinity where it never ends.
  double duration_seconds() const;
  Scene scene_at(double seconds) const {
    Scene scene = loaded_.is_animated ? loaded_.at_time(seconds) : loaded_.scene;
    if (environment_) scene.environment = *environment_;
    if (environment_) scene.environment_map = environment_map_;
    look_.apply(scene);
    return scene;
  }
  // Settles light, background and exposure by small pictures of the first frame; they hold for all
  // scenes and settings from now on. A light that is added is told in a line. Returns: the
  // session's refusal, or kCancelled.
  Status settle(Session& session, const MasterOptions& options, Progress& progress,
                const std::function<bool()>& should_stop);
  // Whether the session shows the first frame's scene since settle().
  bool is_committed() const { return look_.is_committed; }
  // What settling has cost.
  const SceneCost& scene_cost() const { return look_.scene_cost; }
  // Everything but the camera and the time is the same for all frames.
  FrameSettings settings_at(double frame) const;

 private:
  LoadedScene loaded_;
  Look look_;
  FrameSettings settings_;
  Camera camera_at(double frame) const;

  CameraChoice camera_;
  std::optional<std::size_t> followed_;  // the scene's camera that moves with the scene's time
  std::optional<Vec3f> environment_;
  std::shared_ptr<const EnvironmentMap> environment_map_;
  double fps_ = 24;
  double orbit_degrees_ = 0;  // from frame_first_ to frame_last_
  long frame_first_ = 0, frame_last_ = 0;
  Vec3f orbit_centre_;
};

// `camera` turned round the axis through `centre` along its up vector. Exact at 0 degrees.
Camera turned(const Camera& camera, Vec3f centre, double degrees);

// Waits until `session` has options.session.slaves_min slaves, and prints a line every 5 s.
// Returns: kDeadlineExceeded after --wait seconds, kCancelled on a signal.
Status wait_for_slaves(Session& session, const MasterOptions& options,
                       const std::function<bool()>& should_stop);

}  // namespace tessera::master
