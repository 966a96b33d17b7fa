// SPDX-License-Identifier: Apache-2.0
#include "master/import/texture_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

#include "common/base/limits.h"
#include "common/scene_io/confined_path.h"
#include "master/image/plugin_loader.h"

namespace tessera::import {
namespace {

constexpr float kHalfMax = 65504;

// Messages of libraries end in line breaks, or have them inside.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// The format that a picture's first bytes say it has, as OpenImageIO calls it.
Result<std::string> format_of(std::span<const std::byte> bytes) {
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                              std::min<std::size_t>(bytes.size(), 16));
  if (head.starts_with("\x89PNG")) return std::string("png");
  if (head.starts_with("\xff\xd8\xff")) return std::string("jpeg");
  if (head.starts_with("RIFF") && head.substr(8).starts_with("WEBP")) return std::string("webp");
  if (head.starts_with("\xabKTX 20")) return Status::unimplemented("is of KTX2, which is not read");
  return Status::data_loss("is no PNG, JPEG or WebP picture");
}

// One picture that the plug-in has opened. Its errors are one line.
class OpenPicture {
 public:
  // `format`: the format of `bytes`; empty: the picture is the file `path`.
  static Result<OpenPicture> open(const std::string& path, const std::string& format,
                                  std::span<const std::byte> bytes) {
    const auto plugin = master::image_plugin();
    if (!plugin.is_ok()) return plugin.status();
    OpenPicture opened(*plugin);
    char error[kErrorBytes] = {};
    opened.picture_.reset(
        plugin->open_picture(path.c_str(), format.empty() ? nullptr : format.c_str(), bytes.data(),
                             bytes.size(), &opened.shape_, error, sizeof(error)));
    if (opened.picture_ == nullptr) return Status::data_loss("cannot be read: " + one_line(error));
    return opened;
  }

  const master::PluginShape& shape() const { return shape_; }
  // The first `channels` of each pixel, interleaved.
  template <typename Texel>
  Status read(int channels, std::vector<Texel>& texels) const {
    static_assert(sizeof(Texel) == 1 || sizeof(Texel) == 2 || sizeof(Texel) == 4);
    const auto type = sizeof(Texel) == 1   ? master::PluginTexels::kUint8
                      : sizeof(Texel) == 2 ? master::PluginTexels::kUint16
                                           : master::PluginTexels::kFloat;
    texels.resize(static_cast<std::size_t>(shape_.width) * static_cast<std::size_t>(shape_.height) *
                  static_cast<std::size_t>(channels));
    char error[kErrorBytes] = {};
    if (plugin_.read_picture(picture_.get(), type, channels, texels.data(), error, sizeof(error)) !=
        0)
      return Status::data_loss("is damaged: " + one_line(error));
    return {};
  }

 private:
  static constexpr std::size_t kErrorBytes = 512;
  explicit OpenPicture(const master::ImagePlugin& plugin)
      : plugin_(plugin), picture_(nullptr, plugin.close_picture) {}

  master::ImagePlugin plugin_;
  std::unique_ptr<master::PluginPicture, master::ClosePictureFunction> picture_;
  master::PluginShape shape_;
};

// Makes RGBA of the picture's channels; grey becomes all three colours.
template <typename Texel>
Status read_texels(const OpenPicture& picture, std::vector<Texel>& rgba) {
  const auto channels = static_cast<std::size_t>(picture.shape().channels);
  std::vector<Texel> texels;
  if (Status status = picture.read(picture.shape().channels, texels); !status.is_ok())
    return status;
  const std::size_t count = texels.size() / channels;
  rgba.resize(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Texel* from = texels.data() + i * channels;
    Texel* to = rgba.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c) to[c] = from[channels >= 3 ? c : 0];
    to[3] = channels == 4 ? from[3] : channels == 2 ? from[1] : std::numeric_limits<Texel>::max();
  }
  return {};
}

Result<std::shared_ptr<const Texture>> decode(const OpenPicture& picture) {
  const master::PluginShape& shape = picture.shape();
  if (shape.width < 1 || shape.height < 1 || shape.width > kTextureSideMaxPx ||
      shape.height > kTextureSideMaxPx || shape.depth > 1) {
    return Status::resource_exhausted("its sides must be 1 to " +
                                      std::to_string(kTextureSideMaxPx) + " pixels");
  }
  if (shape.channels < 1 || shape.channels > 16) return Status::data_loss("has no colour channels");
  auto texture = std::make_shared<Texture>();
  texture->width_px = shape.width;
  texture->height_px = shape.height;
  const Status status =
      shape.is_uint8 ? read_texels(picture, texture->rgba) : read_texels(picture, texture->rgba16);
  if (!status.is_ok()) return status;
  return std::shared_ptr<const Texture>(std::move(texture));
}

}  // namespace

Result<std::shared_ptr<const Texture>> read_texture_file(const std::string& folder,
                                                         const std::string& name) {
  const auto file = confined_path(folder, name);
  if (!file.is_ok()) return file.status();
  const auto picture = OpenPicture::open(*file, "", {});
  if (!picture.is_ok()) return picture.status();
  return decode(*picture);
}

Result<std::shared_ptr<const EnvironmentMap>> read_environment_file(const std::string& path) {
  const auto picture = OpenPicture::open(path, "", {});
  if (!picture.is_ok()) return Status::data_loss(path + ": " + picture.status().message());
  const master::PluginShape& shape = picture->shape();
  if (shape.width < 1 || shape.height < 1 || shape.width > kEnvironmentSideMaxPx ||
      shape.height > kEnvironmentSideMaxPx || shape.depth > 1) {
    return Status::resource_exhausted(path + ": its sides must be 1 to " +
                                      std::to_string(kEnvironmentSideMaxPx) +
                                      " pixels; make it smaller");
  }
  if (shape.channels < 3) return Status::data_loss(path + ": has no red, green and blue channels");
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = shape.width;
  map->height_px = shape.height;
  if (const Status status = picture->read(3, map->rgb); !status.is_ok())
    return Status::data_loss(path + ": " + status.message());
  // Filters overshoot below zero, and half-floats hold bright suns as infinity. NaN stays, and is
  // refused.
  for (float& x : map->rgb) x = x < 0 ? 0 : std::isinf(x) ? kHalfMax : x;
  return std::shared_ptr<const EnvironmentMap>(std::move(map));
}

TextureLoader textures_beside(const std::string& path) {
  return [folder = std::filesystem::path(path).parent_path().string()](const std::string& name) {
    return read_texture_file(folder, name);
  };
}

Result<std::shared_ptr<const Texture>> read_picture(std::span<const std::byte> bytes) {
  const auto format = format_of(bytes);
  if (!format.is_ok()) return format.status();
  const auto picture = OpenPicture::open("", *format, bytes);
  if (!picture.is_ok()) return picture.status();
  return decode(*picture);
}

}  // namespace tessera::import
