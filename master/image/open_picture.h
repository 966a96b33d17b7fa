// SPDX-License-Identifier: Apache-2.0
// A picture that the plug-in has opened and not decoded yet, so that its shape can be judged first.
// Its errors are one line, worded to follow the picture's name. Threads. One at a time.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "master/image/picture_format.h"
#include "master/image/plugin_loader.h"

namespace tessera::master {

class OpenPicture {
 public:
  // Opens a file whose suffix and content agree (picture_format.h).
  static Result<OpenPicture> open_file(const std::string& path);
  // Opens bytes by the reader of one format; they outlive the picture.
  static Result<OpenPicture> open_bytes(const char* reader, std::span<const std::byte> bytes);

  const PluginShape& shape() const { return shape_; }
  std::uint64_t file_bytes() const { return file_bytes_; }

  // Reads the first `channels` of each pixel to a place of `stride` texels, of which the others
  // stay as they are. Texel: uint8, uint16 or float.
  // Requires: channels <= stride, channels <= shape().channels; `texels` has
  // width * height * stride elements.
  template <typename Texel>
  Status read(int channels, int stride, std::span<Texel> texels) const {
    static_assert(sizeof(Texel) == 1 || sizeof(Texel) == 2 || sizeof(Texel) == 4);
    return read_as(sizeof(Texel) == 1   ? PluginTexels::kUint8
                   : sizeof(Texel) == 2 ? PluginTexels::kUint16
                                        : PluginTexels::kFloat,
                   channels, stride, texels.data());
  }

  // Makes values, of which the picture's first channels are, linear by the encoding that the file
  // states, else as sRGB for integers and as linear for floats. Returns: whether they were not.
  bool make_linear(std::span<float> values) const;
  // Text attributes of the file, "name=value" each.
  std::vector<std::string> attributes() const;

 private:
  explicit OpenPicture(const ImagePlugin& plugin)
      : plugin_(plugin), picture_(nullptr, plugin.close_picture) {}
  static Result<OpenPicture> open(const std::string& path, const char* reader,
                                  std::span<const std::byte> bytes);
  Status read_as(PluginTexels type, int channels, int stride, void* texels) const;

  ImagePlugin plugin_;
  std::unique_ptr<PluginPicture, ClosePictureFunction> picture_;
  PluginShape shape_;
  std::uint64_t file_bytes_ = 0;
};

}  // namespace tessera::master
