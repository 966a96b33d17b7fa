// The viewer: GLFW window with the newest frame, camera controls, overlay.
//
// Threads. Viewer belongs to the main thread (GLFW demands it). publish() may be called by any thread: it replaces the
// newest frame in a single slot, so a slow window skips frames and never slows the cluster.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_stats.h"
#include "common/scene/camera.h"
#include "common/math/bounds3.h"

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
  Bounds3f bounds;              // of the scene: scales speeds of pan, zoom and fly
  std::string screenshot_path;  // tests: when not empty, save the window (PNG) after `screenshot_after` frames and end
  int screenshot_after = 0;
  bool shows_overlay = true;
};

class Viewer {
 public:
  // Returns: kUnavailable, one line: no display, or OpenGL older than 3.3 (naming what is there).
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

  // Main thread: handles events and draws, at the display's rate, until the window is closed (Esc, q) or `should_stop`
  // returns true.
  virtual void run(const std::function<bool()>& should_stop) = 0;
};

}  // namespace tessera::master
