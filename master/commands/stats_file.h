// SPDX-License-Identifier: Apache-2.0
// --stats FILE.jsonl: one JSON object per finished frame (keys: design contract), flushed line by
// line.
#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_stats.h"
#include "master/image/image_error.h"

namespace tessera::master {

// What is known of a frame that is one of several, or that is compared with a reference.
struct PassReport {
  int pass = 0, passes = 1;
  double seconds = 0;               // of all passes so far
  std::optional<ImageError> error;  // of the mean so far
};

std::string stats_json(const FrameStats& stats, int width_px, int height_px, PixelFormat pixels,
                       const PassReport& report = {});

// Used by one thread.
class StatsFile {
 public:
  // An empty path writes nothing. Returns: one line naming file and reason.
  static Result<StatsFile> open(const std::string& path);
  Status write(const FrameStats& stats, const FrameImage& image, const PassReport& report = {});

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace tessera::master
