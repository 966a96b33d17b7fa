#include "master/import/texture_reader.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "common/base/limits.h"
#include "common/scene_io/confined_path.h"

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

// RGBA from what the picture has; grey is all three.
template <typename Texel>
bool read_texels(OIIO::ImageInput& input, OIIO::TypeDesc type, std::vector<Texel>& rgba) {
  const OIIO::ImageSpec& spec = input.spec();
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  const std::size_t count =
      static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  std::vector<Texel> texels(count * channels);
  if (!input.read_image(0, 0, 0, spec.nchannels, type, texels.data())) return false;
  rgba.resize(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Texel* from = texels.data() + i * channels;
    Texel* to = rgba.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c) to[c] = from[channels >= 3 ? c : 0];
    to[3] = channels == 4 ? from[3] : channels == 2 ? from[1] : std::numeric_limits<Texel>::max();
  }
  return true;
}

Result<std::shared_ptr<const Texture>> decode(OIIO::ImageInput& input) {
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kTextureSideMaxPx ||
      spec.height > kTextureSideMaxPx || spec.depth > 1) {
    return Status::resource_exhausted("its sides must be 1 to " +
                                      std::to_string(kTextureSideMaxPx) + " pixels");
  }
  if (spec.nchannels < 1 || spec.nchannels > 16) return Status::data_loss("has no colour channels");
  auto texture = std::make_shared<Texture>();
  texture->width_px = spec.width;
  texture->height_px = spec.height;
  const bool is_read = spec.format == OIIO::TypeDesc::UINT8
                           ? read_texels(input, OIIO::TypeDesc::UINT8, texture->rgba)
                           : read_texels(input, OIIO::TypeDesc::UINT16, texture->rgba16);
  if (!is_read) return Status::data_loss("is damaged: " + one_line(input.geterror()));
  return std::shared_ptr<const Texture>(std::move(texture));
}

}  // namespace

Result<std::shared_ptr<const Texture>> read_texture_file(const std::string& folder,
                                                         const std::string& name) {
  const auto file = confined_path(folder, name);
  if (!file.is_ok()) return file.status();
  auto input = OIIO::ImageInput::open(*file);
  if (!input) return Status::data_loss("cannot be read: " + OIIO::geterror());
  return decode(*input);
}

Result<std::shared_ptr<const EnvironmentMap>> read_environment_file(const std::string& path) {
  auto input = OIIO::ImageInput::open(path);
  if (!input) return Status::data_loss(path + ": cannot be read: " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kEnvironmentSideMaxPx ||
      spec.height > kEnvironmentSideMaxPx || spec.depth > 1) {
    return Status::resource_exhausted(path + ": its sides must be 1 to " +
                                      std::to_string(kEnvironmentSideMaxPx) +
                                      " pixels; make it smaller");
  }
  if (spec.nchannels < 3) return Status::data_loss(path + ": has no red, green and blue channels");
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = spec.width;
  map->height_px = spec.height;
  map->rgb.resize(3 * static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
  if (!input->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, map->rgb.data()))
    return Status::data_loss(path + ": is damaged: " + input->geterror());
  // What filters overshoot, and suns that half-floats cannot hold; NaN stays, and is refused.
  for (float& x : map->rgb) x = x < 0 ? 0 : std::isinf(x) ? kHalfMax : x;
  return std::shared_ptr<const EnvironmentMap>(std::move(map));
}

Result<std::shared_ptr<const Texture>> read_picture(std::span<const std::byte> bytes) {
  const auto format = format_of(bytes);
  if (!format.is_ok()) return format.status();
  // That reader and no other: what is not its format is refused, not tried on the next one.
  auto input = OIIO::ImageInput::create(*format);
  if (!input) return Status::unimplemented("cannot be read: " + OIIO::geterror());
  OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
  OIIO::ImageSpec spec, config;
  config["oiio:UnassociatedAlpha"] = 1;  // colours as they are stored
  if (!input->set_ioproxy(&memory) || !input->open("picture." + *format, spec, config))
    return Status::data_loss("cannot be read: " + one_line(input->geterror()));
  return decode(*input);
}

}  // namespace tessera::import
