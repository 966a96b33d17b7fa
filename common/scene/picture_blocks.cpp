// SPDX-License-Identifier: Apache-2.0
#include "common/scene/picture_blocks.h"

#include "common/scene/block_bytes.h"

namespace tessera {

std::vector<std::byte> encode_texture(const Texture& texture) {
  BlockWriter out(BlockKind::kTexture);
  out.put(std::int32_t{texture.width_px});
  out.put(std::int32_t{texture.height_px});
  out.put(std::uint32_t{texture.is_srgb ? 1u : 0u});
  out.put(static_cast<std::uint32_t>(texture.wrap_u));
  out.put(static_cast<std::uint32_t>(texture.wrap_v));
  out.put(std::uint32_t{texture.is_nearest ? 1u : 0u});
  out.put_array(texture.rgba);
  out.put_array(texture.rgba16);
  return out.finish();
}

std::shared_ptr<const Texture> decode_texture(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  auto texture = std::make_shared<Texture>();
  if (!in.open(BlockKind::kTexture)) return nullptr;
  texture->width_px = in.get<std::int32_t>();
  texture->height_px = in.get<std::int32_t>();
  texture->is_srgb = in.get<std::uint32_t>() != 0;
  const bool is_wrapped = get_enum(in, texture->wrap_u, TextureWrap::kClamp) &&
                          get_enum(in, texture->wrap_v, TextureWrap::kClamp);
  texture->is_nearest = in.get<std::uint32_t>() != 0;
  const bool is_good = is_wrapped && in.get_array(texture->rgba) && in.get_array(texture->rgba16);
  return is_good && in.is_finished() ? texture : nullptr;
}

std::vector<std::byte> encode_environment(const EnvironmentMap& map) {
  BlockWriter out(BlockKind::kEnvironment);
  out.put(std::int32_t{map.width_px});
  out.put(std::int32_t{map.height_px});
  out.put_array(map.rgb);
  return out.finish();
}

std::shared_ptr<const EnvironmentMap> decode_environment(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  auto map = std::make_shared<EnvironmentMap>();
  if (!in.open(BlockKind::kEnvironment)) return nullptr;
  map->width_px = in.get<std::int32_t>();
  map->height_px = in.get<std::int32_t>();
  return in.get_array(map->rgb) && in.is_finished() ? map : nullptr;
}

}  // namespace tessera
