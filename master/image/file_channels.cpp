// SPDX-License-Identifier: Apache-2.0
#include "master/image/file_channels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "common/base/check.h"

namespace tessera::master {
namespace {

std::size_t bytes_of(PluginPixels type) {
  return type == PluginPixels::kUint8 ? 1 : type == PluginPixels::kHalf ? 2 : 4;
}

// Writes `bytes` of each pixel, packed in `from`, to their place among `pixel_bytes` of the file.
void interleave(std::span<const std::byte> from, std::size_t bytes, std::size_t before_bytes,
                std::size_t pixel_bytes, std::vector<std::byte>& to) {
  for (std::size_t i = 0; i * bytes < from.size(); ++i)
    std::memcpy(to.data() + i * pixel_bytes + before_bytes, from.data() + i * bytes, bytes);
}

// Divides linear `rgb` by alpha, as the header says under "Alpha".
void unmultiply(std::span<const float> alpha, std::vector<float>& rgb) {
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    const float share = alpha[i] > 0 ? 1 / alpha[i] : 0;
    for (std::size_t c = 0; c < 3 && share != 1; ++c) rgb[3 * i + c] *= share;
  }
}

std::vector<std::byte> codes_of(std::span<const float> alpha) {
  std::vector<std::byte> codes(alpha.size());
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    const float share = std::clamp(alpha[i], 0.0f, 1.0f);
    codes[i] = static_cast<std::byte>(static_cast<std::uint8_t>(std::lround(255 * share)));
  }
  return codes;
}

bool is_display_file(const std::string& suffix) {
  return suffix == ".png" || suffix == ".jpg" || suffix == ".jpeg";
}

}  // namespace

PlaneSet planes_held_by(const std::string& suffix) {
  if (suffix == ".exr") return PlaneSet::all();
  return suffix == ".png" ? PlaneSet{Plane::kAlpha} : PlaneSet{};
}

Result<FileChannels> file_channels(const FrameImage& image, const std::string& suffix,
                                   bool is_half_exr, const DisplayTransform& display) {
  if ((image.planes.bits() & ~planes_held_by(suffix).bits()) != 0)
    return Status::invalid_argument("a " + suffix.substr(std::min<std::size_t>(1, suffix.size())) +
                                    " file cannot hold the planes of the picture; give OUT.exr");
  const bool is_display = is_display_file(suffix);
  const PluginPixels type = is_display                        ? PluginPixels::kUint8
                            : suffix == ".exr" && is_half_exr ? PluginPixels::kHalf
                                                              : PluginPixels::kFloat;
  const PluginPixels plane_type = is_display ? type : PluginPixels::kFloat;
  const PixelFormat format = type == PluginPixels::kUint8  ? PixelFormat::kDisplay8
                             : type == PluginPixels::kHalf ? PixelFormat::kHalf
                                                           : PixelFormat::kFloat;
  const bool is_shown = image.format == PixelFormat::kDisplay8;
  FileChannels file(image, format, is_shown ? DisplayTransform{} : display);
  for (const char* name : {"R", "G", "B"}) file.channels_.push_back({name, type});
  image.planes.for_each([&](Plane plane) {
    const PlaneRow& row = plane_row(plane);
    for (std::size_t c = 0; c < row.channel_count(); ++c)
      file.channels_.push_back({row.channels[c].data(), plane_type});
  });
  for (const PluginChannel& channel : file.channels_) file.pixel_bytes_ += bytes_of(channel.type);
  return file;
}

std::vector<float> FileChannels::plane_values(std::size_t first_pixel, std::size_t count,
                                              Plane plane) const {
  std::vector<float> values(count * plane_row(plane).channel_count());
  image_->layout().for_each_plane([&](Plane one, std::size_t before_bytes, std::size_t bytes) {
    if (one != plane) return;
    const std::size_t begin = image_->pixel_count() * before_bytes + first_pixel * bytes;
    std::memcpy(values.data(), image_->bytes.data() + begin, count * bytes);
  });
  return values;
}

std::span<const std::byte> FileChannels::rows(int first, int count) {
  TESSERA_CHECK(first >= 0 && count >= 1 && count <= image_->height_px - first);
  const auto width = static_cast<std::size_t>(image_->width_px);
  const std::size_t first_pixel = static_cast<std::size_t>(first) * width;
  const std::size_t pixels = static_cast<std::size_t>(count) * width;
  const std::size_t image_colour_bytes = image_->layout().colour_bytes();
  const bool is_display = format_ == PixelFormat::kDisplay8;
  rgb_.resize(3 * pixels);
  decode_pixels(
      image_->colour().subspan(first_pixel * image_colour_bytes, pixels * image_colour_bytes),
      image_->format, rgb_);
  if (is_display && image_->planes.has(Plane::kAlpha))
    unmultiply(plane_values(first_pixel, pixels, Plane::kAlpha), rgb_);
  const auto colour_bytes = static_cast<std::size_t>(bytes_per_pixel(format_));
  colour_.resize(pixels * colour_bytes);
  encode_pixels(rgb_, format_, colour_, display_);
  if (image_->planes.is_empty()) return colour_;

  pixels_.resize(pixels * pixel_bytes_);
  interleave(colour_, colour_bytes, 0, pixel_bytes_, pixels_);
  std::size_t before_bytes = colour_bytes;
  image_->planes.for_each([&](Plane plane) {
    const std::vector<float> values = plane_values(first_pixel, pixels, plane);
    const std::size_t bytes = bytes_of(channels_.back().type) * plane_row(plane).channel_count();
    const std::vector<std::byte> codes = is_display ? codes_of(values) : std::vector<std::byte>();
    interleave(is_display ? std::span<const std::byte>(codes) : std::as_bytes(std::span(values)),
               bytes, before_bytes, pixel_bytes_, pixels_);
    before_bytes += bytes;
  });
  return pixels_;
}

}  // namespace tessera::master
