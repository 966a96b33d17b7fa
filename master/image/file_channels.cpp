// SPDX-License-Identifier: Apache-2.0
#include "master/image/file_channels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

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
  const bool is_display = is_display_file(suffix), has_alpha = image.planes.has(Plane::kAlpha);
  const PluginPixels type = is_display                        ? PluginPixels::kUint8
                            : suffix == ".exr" && is_half_exr ? PluginPixels::kHalf
                                                              : PluginPixels::kFloat;
  const PluginPixels plane_type = is_display ? type : PluginPixels::kFloat;
  FileChannels file;
  for (const char* name : {"R", "G", "B"}) file.channels.push_back({name, type});
  image.planes.for_each([&](Plane plane) {
    const PlaneRow& row = plane_row(plane);
    for (std::size_t c = 0; c < row.channel_count(); ++c)
      file.channels.push_back({row.channels[c].data(), plane_type});
  });

  const std::size_t count = image.pixel_count();
  std::vector<float> rgb(3 * count);
  decode_pixels(image.colour(), image.format, rgb);
  if (is_display && has_alpha) unmultiply(image.plane_values(Plane::kAlpha), rgb);
  const PixelFormat format = type == PluginPixels::kUint8  ? PixelFormat::kDisplay8
                             : type == PluginPixels::kHalf ? PixelFormat::kHalf
                                                           : PixelFormat::kFloat;
  std::vector<std::byte> colour(count * static_cast<std::size_t>(bytes_per_pixel(format)));
  const bool is_shown = image.format == PixelFormat::kDisplay8;
  encode_pixels(rgb, format, colour, is_shown ? DisplayTransform{} : display);
  if (image.planes.is_empty()) {
    file.pixels = std::move(colour);
    return file;
  }
  const std::size_t colour_bytes = 3 * bytes_of(type);
  const std::size_t pixel_bytes = colour_bytes + bytes_of(plane_type) * channel_count(image.planes);
  file.pixels.resize(count * pixel_bytes);
  interleave(colour, colour_bytes, 0, pixel_bytes, file.pixels);
  std::size_t before_bytes = colour_bytes;
  image.planes.for_each([&](Plane plane) {
    const std::vector<float> values = image.plane_values(plane);
    const std::size_t bytes = bytes_of(plane_type) * plane_row(plane).channel_count();
    const std::vector<std::byte> codes = is_display ? codes_of(values) : std::vector<std::byte>();
    interleave(is_display ? std::span<const std::byte>(codes) : std::as_bytes(std::span(values)),
               bytes, before_bytes, pixel_bytes, file.pixels);
    before_bytes += bytes;
  });
  return file;
}

}  // namespace tessera::master
