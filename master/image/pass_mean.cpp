// SPDX-License-Identifier: Apache-2.0
#include "master/image/pass_mean.h"

#include <cstring>

#include "common/base/check.h"

namespace tessera::master {

void PassMean::add(const FrameImage& image) {
  const std::size_t floats = 3 * image.pixel_count();
  if (image.width_px != width_px_ || image.height_px != height_px_ || image.format != format_ ||
      image.planes != planes_)
    count_ = 0;
  if (count_ == 0) sum_.assign(floats, 0.0);
  width_px_ = image.width_px;
  height_px_ = image.height_px;
  format_ = image.format;
  planes_ = image.planes;
  mean_.resize(floats);
  decode_pixels(image.colour(), image.format, mean_);
  planes_.for_each([&](Plane plane) { add_plane(image, plane); });
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
  image.planes = planes_;
  const PixelLayout layout = image.layout();
  const std::size_t count = image.pixel_count();
  image.bytes.resize(count * layout.pixel_bytes());
  encode_pixels(mean_, format_, std::span(image.bytes).first(count * layout.colour_bytes()));
  layout.for_each_plane([&](Plane plane, std::size_t before_bytes, std::size_t bytes) {
    const std::vector<float> values = plane_values(plane);
    std::memcpy(image.bytes.data() + count * before_bytes, values.data(), count * bytes);
  });
  return image;
}

// Adds a plane of the next picture; count_ is the number of pictures before it.
void PassMean::add_plane(const FrameImage& image, Plane plane) {
  const auto number = static_cast<std::size_t>(plane);
  if (plane_sums_.size() <= number) plane_sums_.resize(number + 1);
  PlaneSum& of = plane_sums_[number];
  if (plane_row(plane).merge == PlaneMerge::kNearest) {
    if (count_ == 0) of.first = image.plane_values(plane);
    return;
  }
  const std::vector<float> values = image.plane_values(plane);
  if (count_ == 0) of.sum.assign(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) of.sum[i] += static_cast<double>(values[i]);
}

std::vector<float> PassMean::plane_values(Plane plane) const {
  const PlaneSum& of = plane_sums_[static_cast<std::size_t>(plane)];
  const PlaneMerge merge = plane_row(plane).merge;
  if (merge == PlaneMerge::kNearest) return of.first;
  const double share = merge == PlaneMerge::kSum ? 1 : 1.0 / count_;
  std::vector<float> values(of.sum.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(of.sum[i] * share);
  return values;
}

}  // namespace tessera::master
