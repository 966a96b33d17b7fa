// SPDX-License-Identifier: Apache-2.0
// Picture files through OpenImageIO, which is a plug-in (tessera_image_oiio.so) loaded when first
// needed: it is slow to start and 134 MB large.
//
// Threads. One at a time (the image thread).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/frame/frame_image.h"

namespace tessera::master {

// The OUT of a command line: a path that ends in .exr, .png, .jpg, .jpeg, .hdr or .pfm and holds
// either no % at all or exactly one %0Nd (N 1..9).
class OutputPattern {
 public:
  // Checks the pattern, the folder (exists, writable) and, for several frames, that there is a
  // %0Nd. Returns: kInvalidArgument / kNotFound / kPermissionDenied with what to do.
  static Result<OutputPattern> parse(const std::string& text, bool has_several_frames);
  std::string path(long frame_number) const;

 private:
  std::string prefix_, suffix_;  // around the number
  int digits_ = 0;               // 0: no number
};

struct WriteOptions {
  bool is_half_exr = false;  // EXR with half floats
  // How linear pixels are shown in PNG and JPEG files. display8 pixels are shown already.
  DisplayTransform display{};
  // Names and values that are stored in files whose format can hold them: EXR, PNG, JPEG.
  std::vector<std::pair<std::string, std::string>> attributes{};
};

// Writes a file, some rows at a time, under a temporary name beside `path`, syncs and renames it.
// PNG and JPEG hold pixels that are exposed, tone-mapped and sRGB-encoded, 8 bit; EXR, HDR and PFM
// are linear. Planes: file_channels.h. Returns: one line naming file and reason; then no file of
// that name was left or changed.
Status write_image(const FrameImage& image, const std::string& path, const WriteOptions& options);

}  // namespace tessera::master
