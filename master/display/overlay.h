// SPDX-License-Identifier: Apache-2.0
// What is written over the picture: speeds, slaves, help. All of Dear ImGui stands in overlay.cpp.
//
// Threads. Main thread, with the window's context current from construction to destruction.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "master/display/viewer_frame.h"

struct GLFWwindow;

namespace tessera::master {

// What the overlay shows and what its widgets change.
struct OverlayState {
  bool shows_overlay = true;
  bool shows_help = false;
  bool shows_slaves = true;  // one row for each, at most kSlaveRowsMax
  bool tints_tiles = false;
  double frames_per_second = 0;          // delivered, also those that the window skipped
  ViewerFrame frame;                     // newest drawn; image is null before the first
  std::optional<ClusterStatus> cluster;  // newest heard of
  std::string notice;                    // a line below; empty: none
};

class Overlay {
 public:
  // Installs its event callbacks after those that the window has (and calls those, too).
  explicit Overlay(GLFWwindow* window);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  void draw(OverlayState& state);
  bool is_mouse_over() const;  // presses and wheel belong to the overlay

 private:
  bool is_ready_ = false;
};

}  // namespace tessera::master
