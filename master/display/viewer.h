// The viewer: GLFW window with the newest frame, camera controls, overlay.
//
// Threads. Viewer belongs to the main thread (GLFW demands it): open(), run() and the destructor
// are called there. publish() and view() may be called by any thread between open() and
// destruction. publish() replaces the newest frame in a single slot, so a slow window skips frames
// and never slows the cluster. One Viewer at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_stats.h"
#include "common/math/bounds3.h"
#include "common/scene/camera.h"

namespace tessera::master {

// What the window shows beside the picture; copied in with each frame.
struct ViewerFrame {
  std::shared_ptr<const FrameImage> image;
  FrameStats stats;
  ClusterStatus cluster;
  double latency_seconds = 0;  // from submit to delivery
};

struct ViewerOptions {
  std::string title;
  int width_px = 640, height_px = 480;
  Camera camera;
  Bounds3f bounds;  // of the scene: scales speeds of pan, zoom and fly
  bool shows_overlay = true;
  bool tints_tiles = false;  // by the slave that drew them
  bool shows_help = false;
  // When screenshot_path is not empty, the window as drawn is handed to save (kDisplay8)
  // once `screenshot_after` published frames (at least 1) have been drawn, and run() ends. The
  // caller brings the writer (master/image), so that the display needs no picture files.
  std::string screenshot_path;
  int screenshot_after = 0;
  std::function<Status(const FrameImage&, const std::string& path)> save;
};

class Viewer {
 public:
  // Returns: kUnavailable, one line: no display, or OpenGL older than 3.3 (naming what is there);
  // kInvalidArgument for a screenshot_path without save.
  static Result<std::unique_ptr<Viewer>> open(const ViewerOptions& options);
  virtual ~Viewer() = default;

  virtual void publish(ViewerFrame frame) = 0;  // any thread

  // What the next frame should show. Any thread (a copy under a lock).
  struct View {
    Camera camera;
    int width_px = 0, height_px = 0;
    std::uint64_t revision = 0;  // counts up when anything changed
  };
  virtual View view() const = 0;

  // Main thread: handles events and draws, at the display's rate, until the window is closed (its
  // button, Esc, Ctrl+Q) or `should_stop` returns true (asked at least ten times a second).
  virtual void run(const std::function<bool()>& should_stop) = 0;

  // After run(): what save answered; kCancelled when the window was closed before; ok
  // without a screenshot.
  virtual Status screenshot_status() const = 0;
};

}  // namespace tessera::master
