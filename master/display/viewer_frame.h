// SPDX-License-Identifier: Apache-2.0
// A frame as the window gets it.
//
// Threads. A value; the image in it is shared and not changed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "common/frame/frame_image.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "master/display/picture_layout.h"

namespace tessera::master {

// A picture and what the window says about it.
struct ViewerFrame {
  std::shared_ptr<const FrameImage> image;
  FrameStats stats;
  double latency_seconds = 0;  // from submit to delivery
  // Size of the picture that the image stands for and whose place it fills; 0: the image's own.
  PixelSize stands_for;
  // is_full: the frame is as good as was asked for; only such frames count for a screenshot.
  // passes: the frame is the mean of so many pictures.
  bool is_full = true;
  int passes = 1;
  std::optional<double> average_ev;  // mean stops of the image, for adaptation
  std::uint64_t revision = 0;        // of the view that it shows
  FrameSettings settings;            // with which it was rendered
};

}  // namespace tessera::master
