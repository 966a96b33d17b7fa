// SPDX-License-Identifier: Apache-2.0
// The viewer: GLFW window with the newest frame, camera controls, overlay.
//
// Threads. Viewer belongs to the main thread (GLFW demands it): open(), run() and the destructor
// are called there, and the options' callbacks from there; they return at once. All else may be
// called by any thread between open() and destruction. publish() replaces the newest frame in a
// single slot, so a slow window skips frames and never slows the cluster. One Viewer at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/math/bounds3.h"
#include "common/scene/camera.h"
#include "master/display/play_wish.h"
#include "master/display/viewer_frame.h"

namespace tessera::master {

struct ViewerOptions {
  std::string title;
  int width_px = 640, height_px = 480;
  Camera camera;
  Bounds3f bounds;  // of the scene: scales speeds of pan, zoom and fly
  // The camera of key f for a person who sees the scene with `seen`; none: it shows all bounds.
  std::function<Camera(const Camera& seen, double aspect)> camera_of_all;
  bool shows_overlay = true;
  bool tints_tiles = false;  // by the slave that drew them
  bool shows_help = false;
  // When screenshot_path is not empty, the window as drawn is handed to save (kDisplay8)
  // once `screenshot_after` full frames (at least 1) have been drawn, and run() ends. The
  // caller brings the writer (master/image), so that the display needs no picture files.
  std::string screenshot_path;
  int screenshot_after = 0;
  std::function<Status(const FrameImage&, const std::string& path)> save;
  // Called when a person wants the picture that is shown in a file. Empty: the key does nothing.
  std::function<void(const ViewerFrame&, const DisplayTransform&)> on_save_picture;
  // Called when a person wants the camera as text. Returns: the text for the clipboard.
  std::function<std::string(const Camera&, PixelSize)> on_copy_camera;
};

class Viewer {
 public:
  // Whether there is a display; asked before the scene is read, which may take minutes.
  // Returns: kUnavailable, one line: no display.
  static Status check_display();
  // Returns: kUnavailable, one line: no display, or OpenGL older than 3.3 (naming what is there);
  // kInvalidArgument for a screenshot_path without save.
  static Result<std::unique_ptr<Viewer>> open(const ViewerOptions& options);
  virtual ~Viewer() = default;

  virtual void publish(ViewerFrame frame) = 0;
  virtual void publish_status(ClusterStatus cluster) = 0;
  // How linear pixels are shown from the next frame on; is_automatic: exposure adapts to what
  // frames say of themselves.
  virtual void expose(const DisplayTransform& display, bool is_automatic) = 0;
  // Shows a line for a few seconds, also when the overlay is off; it replaces the line before.
  virtual void notify(std::string line) = 0;

  // What the next frame should show.
  struct View {
    Camera camera;
    int width_px = 0, height_px = 0;
    PlayWish play;
    std::uint64_t revision = 0;  // counts up when anything changed
  };
  virtual View view() const = 0;
  // Waits until the view has another revision, at most so long.
  virtual View wait_for_view(std::uint64_t revision, double seconds_max) const = 0;

  // Main thread: handles events and draws, at the display's rate, until the window is closed (its
  // button, Esc, Ctrl+Q) or `should_stop` returns true (asked at least ten times a second).
  virtual void run(const std::function<bool()>& should_stop) = 0;

  // After run(): what save answered; kCancelled when the window was closed before; ok
  // without a screenshot.
  virtual Status screenshot_status() const = 0;
};

}  // namespace tessera::master
