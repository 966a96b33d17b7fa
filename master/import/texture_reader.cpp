// SPDX-License-Identifier: Apache-2.0
#include "master/import/texture_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

#include "common/base/limits.h"
#include "common/scene_io/confined_path.h"
#include "master/image/open_picture.h"
#include "master/image/picture_budget.h"

namespace tessera::import {
namespace {

using master::OpenPicture;

constexpr float kHalfMax = 65504;

// The reader of OpenImageIO for bytes that a scene holds: one of three formats, which their first
// bytes tell.
Result<const char*> reader_of(std::span<const std::byte> bytes) {
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                              std::min(bytes.size(), master::kPictureHeadBytes));
  if (head.starts_with("\xabKTX 20")) return Status::unimplemented("is of KTX2, which is not read");
  const master::PictureFormat* const format = master::picture_format_of_head(head);
  for (const std::string_view known : {"png", "jpeg", "webp"}) {
    if (format != nullptr && format->reader == known) return format->reader;
  }
  return Status::data_loss("is no PNG, JPEG or WebP picture");
}

// What the pictures of this process, which reads one scene, have been decoded to.
master::PictureBudget& budget() {
  static master::PictureBudget of_the_scene;
  return of_the_scene;
}

std::size_t texel_count(const master::PluginShape& shape) {
  return static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height);
}

// Makes RGBA of the picture's channels; grey becomes all three colours.
template <typename Texel>
Status read_texels(const OpenPicture& picture, std::vector<Texel>& rgba) {
  const int channels = picture.shape().channels, read = channels > 4 ? 3 : channels;
  const std::size_t count = texel_count(picture.shape());
  TESSERA_RETURN_IF_ERROR(budget().book(picture.file_bytes(), count, 4 * sizeof(Texel) * count));
  rgba.assign(4 * count, std::numeric_limits<Texel>::max());
  TESSERA_RETURN_IF_ERROR(picture.read(read, 4, std::span(rgba)));
  if (read >= 3) return {};
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    if (read == 2) rgba[i + 3] = rgba[i + 1];
    rgba[i + 1] = rgba[i + 2] = rgba[i];
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
  const auto picture = OpenPicture::open_file(*file);
  if (!picture.is_ok()) return picture.status();
  return decode(*picture);
}

Result<std::shared_ptr<const EnvironmentMap>> read_environment_file(const std::string& path) {
  const auto picture = OpenPicture::open_file(path);
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
  const std::size_t count = texel_count(shape);
  Status status = budget().book(picture->file_bytes(), count, 3 * sizeof(float) * count);
  if (status.is_ok()) {
    map->rgb.resize(3 * count);
    status = picture->read(3, 3, std::span(map->rgb));
  }
  if (!status.is_ok()) return Status::data_loss(path + ": " + status.message());
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
  const auto reader = reader_of(bytes);
  if (!reader.is_ok()) return reader.status();
  const auto picture = OpenPicture::open_bytes(*reader, bytes);
  if (!picture.is_ok()) return picture.status();
  return decode(*picture);
}

}  // namespace tessera::import
