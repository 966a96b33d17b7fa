// SPDX-License-Identifier: Apache-2.0
// Camera files and the camera text of the command line.
//
// File: lines "eye x y z", "target x y z" (or "at"), "up x y z", "vfov degrees" (or "fov"), "size w
// h", "light x y z" (for benchmarks; skipped here). A line "frame N" begins the keys of frame N;
// keys before the first hold for all. '#' begins a comment. An unknown key is an error with its
// line.
//
// Threads. Plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/camera.h"

namespace tessera {

struct ImageSize {
  int width_px = 0, height_px = 0;
};

class CameraPath {
 public:
  struct Key {
    double frame = 0;
    Camera camera;
  };
  // Requires: keys not empty, frames rising.
  CameraPath(std::vector<Key> keys, std::optional<ImageSize> size)
      : keys_(std::move(keys)), size_(size) {}

  // Catmull-Rom between the keys (E. Catmull, R. Rom, "A Class of Local Interpolating Splines",
  // 1974), constant outside.
  Camera at(double frame) const;
  std::optional<ImageSize> size() const { return size_; }

 private:
  std::vector<Key> keys_;
  std::optional<ImageSize> size_;
};

// Returns: one line naming file and line.
Result<CameraPath> read_camera_file(const std::string& path);

// Parses "ex,ey,ez lx,ly,lz ux,uy,uz fov".
Result<Camera> parse_camera_text(const std::string& text);

// Inverse of parse_camera_text(), which gives the same camera, to the bit.
std::string camera_text(const Camera& camera);

}  // namespace tessera
