// --stats FILE.jsonl: one JSON object per finished frame (keys: design contract), flushed line by
// line.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_stats.h"

namespace tessera::master {

std::string stats_json(const FrameStats& stats, int width_px, int height_px, PixelFormat pixels);

// Used by one thread.
class StatsFile {
 public:
  // An empty path writes nothing. Returns: one line naming file and reason.
  static Result<StatsFile> open(const std::string& path);
  Status write(const FrameStats& stats, const FrameImage& image);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace tessera::master
