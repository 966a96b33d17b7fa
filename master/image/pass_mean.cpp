// SPDX-License-Identifier: Apache-2.0
#include "master/image/pass_mean.h"

#include "common/base/check.h"

namespace tessera::master {

void PassMean::add(const FrameImage& image) {
  const std::size_t floats =
      3 * static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px);
  if (image.width_px != width_px_ || image.height_px != height_px_ || image.format != format_)
    count_ = 0;
  if (count_ == 0) sum_.assign(floats, 0.0);
  width_px_ = image.width_px;
  height_px_ = image.height_px;
  format_ = image.format;
  mean_.resize(floats);
  decode_pixels(image.bytes, image.format, mean_);
  ++count_;
  for (std::size_t i = 0; i < floats; ++i) {
    sum_[i] += static_cast<double>(mean_[i]);
    mean_[i] = static_cast<float>(sum_[i] / count_);
  }
}

FrameImage PassMean::image() const {
  TESSERA_CHECK_GE(count_, 1);
  FrameImage image;
  image.width_px = width_px_;
  image.height_px = height_px_;
  image.format = format_;
  image.bytes.resize(mean_.size() / 3 * static_cast<std::size_t>(bytes_per_pixel(format_)));
  encode_pixels(mean_, format_, image.bytes);
  return image;
}

}  // namespace tessera::master
