// SPDX-License-Identifier: Apache-2.0
#include "master/image/picture_stream.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

constexpr std::uint32_t kMagic = 0x49505354;  // "TSPI"
constexpr std::uint32_t kVersion = 1;

void put(std::vector<std::byte>& out, const void* data, std::size_t size) {
  const auto* begin = static_cast<const std::byte*>(data);
  out.insert(out.end(), begin, begin + size);
}
void put_u32(std::vector<std::byte>& out, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  put(out, &word, sizeof(word));
}
void put_text(std::vector<std::byte>& out, const std::string& text) {
  put_u32(out, text.size());
  put(out, text.data(), text.size());
}

template <typename T>
bool take(std::span<const std::byte>& rest, T& value) {
  if (rest.size() < sizeof(T)) return false;
  std::memcpy(&value, rest.data(), sizeof(T));
  rest = rest.subspan(sizeof(T));
  return true;
}
bool take_text(std::span<const std::byte>& rest, std::string& text) {
  std::uint32_t size = 0;
  if (!take(rest, size) || size > rest.size()) return false;
  text.assign(reinterpret_cast<const char*>(rest.data()), size);
  rest = rest.subspan(size);
  return true;
}

bool is_side(std::uint32_t side) { return side >= 1 && side <= std::uint32_t{kImageSideMaxPx}; }

bool decode(std::span<const std::byte> rest, PictureStream& stream) {
  FloatImage& image = stream.image;
  std::uint32_t magic = 0, version = 0, width = 0, height = 0, count = 0;
  std::uint8_t is_display = 0;
  if (!take(rest, magic) || !take(rest, version) || magic != kMagic || version != kVersion)
    return false;
  if (!take_text(rest, stream.warning)) return false;
  if (!take(rest, width) || !take(rest, height) || !is_side(width) || !is_side(height))
    return false;
  if (!take(rest, is_display) || is_display > 1) return false;
  if (!take(rest, count) || count > kPictureAttributesMax) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string key, text;
    if (!take_text(rest, key) || !take_text(rest, text)) return false;
    image.attributes.emplace(std::move(key), std::move(text));
  }
  const std::size_t floats = std::size_t{3} * width * height;
  if (rest.size() != floats * sizeof(float)) return false;
  image.width_px = static_cast<int>(width);
  image.height_px = static_cast<int>(height);
  image.is_display = is_display != 0;
  image.rgb.resize(floats);
  std::memcpy(image.rgb.data(), rest.data(), rest.size());
  return true;
}

}  // namespace

std::vector<std::byte> encode_picture_stream(const PictureStream& stream) {
  const FloatImage& image = stream.image;
  std::vector<std::byte> out;
  out.reserve(image.rgb.size() * sizeof(float) + 4096);
  put_u32(out, kMagic);
  put_u32(out, kVersion);
  put_text(out, stream.warning);
  put_u32(out, static_cast<std::size_t>(image.width_px));
  put_u32(out, static_cast<std::size_t>(image.height_px));
  out.push_back(std::byte{image.is_display});
  std::size_t left = std::min(image.attributes.size(), kPictureAttributesMax);
  put_u32(out, left);
  for (auto it = image.attributes.begin(); left > 0; ++it, --left) {
    put_text(out, it->first);
    put_text(out, it->second);
  }
  put(out, image.rgb.data(), image.rgb.size() * sizeof(float));
  return out;
}

Result<PictureStream> decode_picture_stream(std::span<const std::byte> bytes) {
  PictureStream stream;
  if (!decode(bytes, stream)) return Status::data_loss("the picture's stream is malformed");
  return stream;
}

}  // namespace tessera::master
