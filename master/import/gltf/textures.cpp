// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/textures.h"

#include <cmath>

#include "master/import/gltf/uri.h"

namespace tessera::import {
namespace {

constexpr std::uint64_t kPictureBytesMax = std::uint64_t{1} << 30;
constexpr int kNearest = 9728, kLinear = 9729;

// The file's v points down and the scene's v up, so v is flipped on both sides of the map of
// KHR_texture_transform, translation * rotation * scale. The rotation is counter-clockwise as the
// picture is seen; with v pointing down it maps u to (cos, -sin).
std::array<float, 6> uv_map(std::array<float, 2> offset, double rotation,
                            std::array<float, 2> scale) {
  const double c = std::cos(rotation), s = std::sin(rotation);
  const double sx = scale[0], sy = scale[1], ox = offset[0], oy = offset[1];
  const std::array<double, 6> map{c * sx, -s * sy, s * sy + ox, s * sx, c * sy, 1 - c * sy - oy};
  std::array<float, 6> rounded{};
  for (std::size_t i = 0; i < 6; ++i) rounded[i] = static_cast<float>(map[i]);
  return rounded;
}

}  // namespace

TextureRef GltfTextures::read(const GltfObject& info, Encoding encoding,
                              std::initializer_list<std::string_view> known) {
  TextureRef ref;
  if (!info.is_there()) return ref;
  for (const std::string& key : info.keys()) {
    const bool is_known = key == "index" || key == "texCoord" || key == "extensions" ||
                          key == "extras" ||
                          std::find(known.begin(), known.end(), key) != known.end();
    if (!is_known) info.warn(printable(key), "is no key that is known here, and is passed over");
  }
  constexpr std::uint64_t kSetsMax = 1000;
  ref.uv_set = info.index("texCoord", kSetsMax, "0 is used").value_or(0);
  const GltfObject moved = info.extension("KHR_texture_transform");
  if (moved.is_there()) {
    moved.check_keys({"offset", "rotation", "scale", "texCoord"}, {});
    ref.uv_map = uv_map(moved.reals<2>("offset", {0, 0}, kAnyNumber),
                        moved.number("rotation", 0, kAnyNumber),
                        moved.reals<2>("scale", {1, 1}, kAnyNumber));
    for (const float x : ref.uv_map) {
      if (!std::isfinite(x)) ref.uv_map = {1, 0, 0, 0, 1, 0};
    }
    if (const auto set = moved.index("texCoord", kSetsMax, "that of the texture is used"))
      ref.uv_set = *set;
  }
  if (!info.has("index")) {
    info.warn("index", "is missing; the plain value is used");
  } else if (const auto index =
                 info.index("index", document_.count("textures"), "the plain value is used")) {
    ref.index = texture(*index, encoding);
  }
  return ref;
}

std::uint32_t GltfTextures::texture(std::uint32_t index, Encoding encoding) {
  const GltfObject source = document_.at("textures", index);
  source.check_keys({"sampler", "source"}, {"KHR_texture_basisu", "EXT_texture_webp"});
  const auto picture = image_of(source);
  Sampler filter;
  if (const auto s = source.index("sampler", document_.count("samplers"), "none is used"))
    filter = sampler(*s);
  if (!picture) return kNoTexture;
  const auto base = image(*picture);
  if (!base) return kNoTexture;
  const std::tuple key(*picture, encoding, filter.wrap_u, filter.wrap_v, filter.is_nearest);
  const auto known = textures_.find(key);
  if (known != textures_.end()) return known->second;
  auto made = std::make_shared<Texture>(*base);
  made->is_srgb = encoding == Encoding::kColour;
  made->wrap_u = filter.wrap_u;
  made->wrap_v = filter.wrap_v;
  made->is_nearest = filter.is_nearest;
  return textures_[key] = add(std::move(made));
}

std::uint32_t GltfTextures::add(std::shared_ptr<const Texture> texture) {
  scene_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::optional<std::uint32_t> GltfTextures::image_of(const GltfObject& texture) {
  const std::size_t count = document_.count("images");
  const GltfObject webp = texture.extension("EXT_texture_webp");
  if (const auto index = webp.index("source", count, "the plain picture is used")) return index;
  const auto plain = texture.index("source", count, "the plain value is used");
  if (texture.extension("KHR_texture_basisu").is_there()) {
    texture.warn("KHR_texture_basisu", std::string("pictures (KTX2) are not read; ") +
                                           (plain ? "the other picture of the texture is used"
                                                  : "the plain value is used"));
  } else if (!plain && !texture.has("source")) {
    texture.warn("source", "is missing; the plain value is used");
  }
  return plain;
}

GltfTextures::Sampler GltfTextures::sampler(std::uint32_t index) const {
  const GltfObject source = document_.at("samplers", index);
  source.check_keys({"magFilter", "minFilter", "wrapS", "wrapT"}, {});
  const auto wrap = [&source](const char* key) {
    switch (static_cast<int>(source.number(key, 10497, {0, 65535}))) {
      case 33071:
        return TextureWrap::kClamp;
      case 33648:
        return TextureWrap::kMirror;
      case 10497:
        return TextureWrap::kRepeat;
      default:
        source.warn(key, "must be 33071, 33648 or 10497; the picture is repeated");
    }
    return TextureWrap::kRepeat;
  };
  Sampler read{wrap("wrapS"), wrap("wrapT")};
  const int magnified = static_cast<int>(source.number("magFilter", kLinear, {0, 65535}));
  if (magnified != kNearest && magnified != kLinear)
    source.warn("magFilter", "must be 9728 or 9729; 9729 (linear) is used");
  read.is_nearest = magnified == kNearest;
  const int reduced = static_cast<int>(source.number("minFilter", kLinear, {0, 65535}));
  const bool is_known =
      reduced == kNearest || reduced == kLinear || (reduced >= 9984 && reduced <= 9987);
  if (!is_known) source.warn("minFilter", "must be 9728, 9729 or 9984 to 9987; it has no effect");
  return read;
}

std::shared_ptr<const Texture> GltfTextures::image(std::uint32_t index) {
  const auto known = images_.find(index);
  if (known != images_.end()) return known->second;
  const GltfObject source = document_.at("images", index);
  source.check_keys({"uri", "mimeType", "bufferView"}, {});
  auto texture = read_image(source);
  if (!texture.is_ok()) {
    document_.warnings().add("image", texture.status().message() + "; the plain value is used");
    return images_[index] = nullptr;
  }
  return images_[index] = *texture;
}

Result<std::shared_ptr<const Texture>> GltfTextures::read_image(const GltfObject& source) {
  const auto decoded = [&](ByteSpan bytes) -> Result<std::shared_ptr<const Texture>> {
    auto texture = decode_(bytes);
    if (texture.is_ok()) return texture;
    const std::string uri = source.text("uri");
    const bool is_file = !uri.empty() && !uri.starts_with("data:");
    return Status::data_loss(source.name() + ": " +
                             (is_file ? "uri '" + printable(uri) + "' " : "the picture ") +
                             texture.status().message());
  };
  if (source.has("uri")) {
    const auto bytes = read_uri(document_.folder(), source.text("uri"), kPictureBytesMax);
    if (!bytes.is_ok()) return source.refuse("uri", bytes.status().message());
    return decoded(std::as_bytes(std::span(*bytes)));
  }
  const auto view = source.refused_index("bufferView", document_.count("bufferViews"));
  if (!view.is_ok()) return view.status();
  if (!*view) return source.refuse("uri", "is missing");
  const auto bytes = document_.view(**view);
  if (!bytes.is_ok()) return bytes.status();
  return decoded(*bytes);
}

TextureRef GltfTextures::roughness_of_glossiness(const TextureRef& source, float factor) {
  const Texture& from = *scene_.textures[source.index];
  auto made = std::make_shared<Texture>(from);
  made->is_srgb = false;
  const auto convert = [factor](auto& texels) {
    using Texel = std::remove_reference_t<decltype(texels[0])>;
    constexpr float kMost = static_cast<float>(std::numeric_limits<Texel>::max());
    for (std::size_t i = 0; i < texels.size(); i += 4) {
      const float glossiness = factor * static_cast<float>(texels[i + 3]) / kMost;
      texels[i] = texels[i + 2] = texels[i + 3] = std::numeric_limits<Texel>::max();
      texels[i + 1] = static_cast<Texel>(std::lround((1 - glossiness) * kMost));
    }
  };
  convert(made->rgba);
  convert(made->rgba16);
  TextureRef ref = source;
  ref.index = add(std::move(made));
  return ref;
}

}  // namespace tessera::import
