// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/scene_pictures.h"

#include <algorithm>
#include <cmath>

#include "common/scene_io/texels.h"

namespace tessera {
namespace {

// Key that tells two pictures of one file apart.
std::string variant_of(const PictureUse& source) {
  std::string text = source.name;
  if (source.base != 0 || source.gain != 1)
    text += '\n' + std::to_string(source.base) + ' ' + std::to_string(source.gain);
  if (source.wrap_u != TextureWrap::kRepeat || source.wrap_v != TextureWrap::kRepeat)
    text += "\nwrap " + std::to_string(static_cast<int>(source.wrap_u)) +
            std::to_string(static_cast<int>(source.wrap_v));
  if (source.is_nearest) text += "\nnearest";
  return text;
}

// channel_of() gives a channel in [0, 3], or kLuminance.
constexpr int kLuminance = 4;
int channel_of(const PictureUse& source, const Texture& picture) {
  switch (source.channel) {
    case 'r':
      return 0;
    case 'g':
      return 1;
    case 'b':
      return 2;
    case 'm':
      return 3;
    default:
      return is_grey(picture) ? 0 : kLuminance;
  }
}

float value_at(const Texture& texture, int x, int y, int channel) {
  return channel == kLuminance ? luminance_at(texture, x, y) : texel_at(texture, x, y, channel);
}

std::shared_ptr<const Texture> grey(const Texture& picture, int channel) {
  return make_texture(picture, picture.width_px, picture.height_px, [&](int x, int y, int c) {
    return c == 3 ? 1 : value_at(picture, x, y, channel);
  });
}

std::shared_ptr<const Texture> as_plain(const Texture& picture) {
  auto copy = std::make_shared<Texture>(picture);
  copy->is_srgb = false;
  return copy;
}

}  // namespace

float roughness_of_exponent(float exponent) { return std::sqrt(std::sqrt(2 / (exponent + 2))); }

std::shared_ptr<const Texture> ScenePictures::load(const PictureUse& source) {
  const auto [known, is_new] = files_.try_emplace(source.name);
  if (!is_new) return known->second;
  auto texture =
      load_ ? load_(source.name)
            : Result<std::shared_ptr<const Texture>>(Status::unimplemented("no textures here"));
  if (texture.is_ok()) return known->second = *texture;
  warnings_->add("picture", source.where + " " + source.name + ": " + texture.status().message() +
                                "; the plain value is used");
  return nullptr;
}

void ScenePictures::warn_of_options(const PictureUse& source) {
  for (const std::string& option : source.not_drawn) {
    warnings_->add("option " + option, source.where + ": '" + option + "' is not drawn");
  }
}

std::shared_ptr<const Texture> ScenePictures::picture(const PictureUse& source) {
  warn_of_options(source);
  auto file = load(source);
  if (file == nullptr) return nullptr;
  const std::string variant = variant_of(source);
  if (variant == source.name) return file;
  auto& made = pictures_[variant];
  if (made != nullptr) return made;
  std::shared_ptr<Texture> changed =
      source.base == 0 && source.gain == 1
          ? std::make_shared<Texture>(*file)
          : make_texture(*file, file->width_px, file->height_px, [&](int x, int y, int c) {
              const float texel = texel_at(*file, x, y, c);
              return c == 3 ? texel : source.base + source.gain * texel;
            });
  changed->is_srgb = file->is_srgb;
  changed->wrap_u = source.wrap_u;
  changed->wrap_v = source.wrap_v;
  changed->is_nearest = source.is_nearest;
  return made = std::move(changed);
}

TextureRef ScenePictures::use(const PictureUse& source, const std::string& use, const Maker& make) {
  const auto from = picture(source);
  if (from == nullptr) return {};
  const auto [known, is_new] = uses_.try_emplace(
      variant_of(source) + '\n' + use, static_cast<std::uint32_t>(scene_.textures.size()));
  if (is_new) scene_.textures.push_back(make(*from));
  TextureRef ref(known->second);
  ref.uv_map = {source.scale.x, 0, source.offset.x, 0, source.scale.y, source.offset.y};
  return ref;
}

TextureRef ScenePictures::color(const PictureUse& source) {
  return use(source, "colour", [&](const Texture&) { return picture(source); });
}

TextureRef ScenePictures::normal(const PictureUse& source) {
  return use(source, "plain", as_plain);
}

TextureRef ScenePictures::bump(const PictureUse& source, float& scale) {
  const auto from = picture(source);
  if (from == nullptr) return {};
  scale = 1;
  if (source.channel == 0 && is_normal_map(*from)) {
    scale = source.bump;
    return normal(source);
  }
  return use(
      source, "bump " + std::to_string(source.bump) + source.channel, [&](const Texture& heights) {
        const int channel = channel_of(source, heights);
        return normals_of_heights(channel == 0 ? heights : *grey(heights, channel), source.bump);
      });
}

TextureRef ScenePictures::opacity(const PictureUse& source, std::uint32_t& channel) {
  const auto from = picture(source);
  if (from == nullptr) return {};
  channel = 3;
  if (source.channel == 'm' || (source.channel == 0 && tessera::has_alpha(*from)))
    return color(source);
  const int value = channel_of(source, *from);
  channel = value == kLuminance ? 0 : static_cast<std::uint32_t>(value);
  if (value != kLuminance) return normal(source);
  return use(source, "luminance", [](const Texture& p) { return grey(p, kLuminance); });
}

TextureRef ScenePictures::roughness_metalness(const PictureUse* roughness,
                                              const PictureUse* metalness) {
  const auto rough = roughness != nullptr ? picture(*roughness) : nullptr;
  const auto metal = metalness != nullptr ? picture(*metalness) : nullptr;
  if (rough == nullptr && metal == nullptr) return {};
  const PictureUse& placed = rough != nullptr ? *roughness : *metalness;
  std::string name = "roughness";
  if (metal != nullptr) name += ", metalness " + variant_of(*metalness) + metalness->channel;
  if (rough != nullptr && metal != nullptr &&
      (roughness->scale != metalness->scale || roughness->offset != metalness->offset)) {
    warnings_->add("two places", metalness->where + " lies elsewhere than " + roughness->where +
                                     "; it is put in its place");
  }
  return use(placed, name + (rough != nullptr ? placed.channel : '-'), [&](const Texture& like) {
    const int width = std::max(like.width_px, metal != nullptr ? metal->width_px : 1);
    const int height = std::max(like.height_px, metal != nullptr ? metal->height_px : 1);
    const int green = rough != nullptr ? channel_of(*roughness, *rough) : 0;
    const int blue = metal != nullptr ? channel_of(*metalness, *metal) : 0;
    const auto nearest = [&](const Texture& t, int x, int y, int channel) {
      return value_at(t, x * t.width_px / width, y * t.height_px / height, channel);
    };
    return make_texture(like, width, height, [&](int x, int y, int c) {
      if (c == 1 && rough != nullptr) return nearest(*rough, x, y, green);
      if (c == 2 && metal != nullptr) return nearest(*metal, x, y, blue);
      return 1.0f;
    });
  });
}

TextureRef ScenePictures::roughness_of_exponents(const PictureUse& source, float ns) {
  return use(source, "exponent " + std::to_string(ns) + source.channel, [&](const Texture& p) {
    const int channel = channel_of(source, p);
    return make_texture(p, p.width_px, p.height_px, [&](int x, int y, int c) {
      return c == 1 ? roughness_of_exponent(ns * value_at(p, x, y, channel)) : 1.0f;
    });
  });
}

bool ScenePictures::has_alpha(const PictureUse& source) {
  const auto from = load(source);
  return from != nullptr && tessera::has_alpha(*from);
}

}  // namespace tessera
