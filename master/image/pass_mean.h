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
  // A picture of another size or format starts anew. Linear radiance is averaged, whatever the
  // format.
  void add(const FrameImage& image);
  int count() const { return count_; }

  // Shape: [3 * width * height], linear. Valid until the next add().
  std::span<const float> mean() const { return mean_; }
  // In the format of the pictures. Requires: count() > 0.
  FrameImage image() const;

 private:
  int count_ = 0;
  int width_px_ = 0, height_px_ = 0;
  PixelFormat format_ = PixelFormat::kFloat;
  std::vector<double> sum_;
  std::vector<float> mean_;
};

}  // namespace tessera::master
