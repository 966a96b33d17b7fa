// SPDX-License-Identifier: Apache-2.0
// The mean of several pictures of one view, each made with other random choices.
//
// Threads. One at a time.
#pragma once

#include <span>
#include <vector>

#include "common/frame/frame_image.h"

namespace tessera::master {

class PassMean {
 public:
  void reset() { count_ = 0; }
  // Adds a picture; one of another size, format or set of planes starts a new mean. Linear radiance
  // is averaged, whatever the format; planes are merged as their rows say (PlaneMerge).
  void add(const FrameImage& image);
  int count() const { return count_; }

  // Shape: [3 * width * height], linear. Valid until the next add().
  std::span<const float> mean() const { return mean_; }
  // The mean in the format of the pictures. Requires: count() > 0.
  FrameImage image() const;

 private:
  int count_ = 0;
  // The values of a plane: `first`, of the first picture, where that one decides, otherwise `sum`.
  struct PlaneSum {
    std::vector<float> first;
    std::vector<double> sum;
  };
  void add_plane(const FrameImage& image, Plane plane);
  std::vector<float> plane_values(Plane plane) const;

  int width_px_ = 0, height_px_ = 0;
  PixelFormat format_ = PixelFormat::kFloat;
  std::vector<double> sum_;
  std::vector<float> mean_;
  PlaneSet planes_;
  std::vector<PlaneSum> plane_sums_;  // by number of the plane, up to the highest of the set
};

}  // namespace tessera::master
