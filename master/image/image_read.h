// Reads a picture file to linear-or-as-stored floats, for comparing. Every format through the
// plug-in. Threads. One at a time.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::master {

struct FloatImage {
  int width_px = 0, height_px = 0;
  std::vector<float> rgb;  // [3 * width * height], row 0 on top
};

// Returns: kDataLoss naming file and reason.
Result<FloatImage> read_image(const std::string& path);

}  // namespace tessera::master
