// SPDX-License-Identifier: Apache-2.0
// Reads a picture file for comparing and makes it linear by its own encoding: integers are sRGB
// unless the file says otherwise. picture_format.h has the formats. Grey becomes all three colours.
//
// What a person names is read in the importer's process: master/loader/load_picture.h.
// Threads. One at a time.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::master {

struct FloatImage {
  int width_px = 0, height_px = 0;
  bool is_display = false;                        // the file's numbers were not linear
  std::vector<float> rgb;                         // [3 * width * height], row 0 on top
  std::map<std::string, std::string> attributes;  // those of the file that are text
};

// Returns: kDataLoss naming file and reason.
Result<FloatImage> read_image(const std::string& path);

}  // namespace tessera::master
