// SPDX-License-Identifier: Apache-2.0
#include "slave/core/scene/texture_table.h"

#include <algorithm>

#include "slave/core/light/light_set.h"

namespace tessera::core {
namespace {

// The place of the textures that lie as this one does; a new place where there is none.
TexturePlace& place_of(const TextureRef& ref, TextureTable& table) {
  const auto set = static_cast<std::int32_t>(ref.uv_set);
  for (std::int32_t k = 0; k < table.place_count; ++k) {
    TexturePlace& place = table.place[k];
    if (place.uv_set == set && std::equal(ref.uv_map.begin(), ref.uv_map.end(), place.uv_map))
      return place;
  }
  TexturePlace& place = table.place[table.place_count++];
  place.uv_set = set;
  place.is_moved = is_moved(ref);
  std::copy(ref.uv_map.begin(), ref.uv_map.end(), place.uv_map);
  return place;
}

}  // namespace

bool has_texture(const Material& material) {
  const auto refs = textures_by_use(material);
  return std::any_of(refs.begin(), refs.end(), [](const TextureRef* r) { return r->is_set(); });
}

TextureTable make_texture_table(const Material& material, std::span<const TextureView> views) {
  TextureTable table{};
  const auto refs = textures_by_use(material);
  for (int use = 0; use < kTextureUses; ++use) {
    const TextureRef& ref = *refs[static_cast<std::size_t>(use)];
    if (!ref.is_set() || (use == kEmissionTexture && is_black(material.emission))) continue;
    place_of(ref, table).uses |= 1u << use;
    table.texture[use] = &views[ref.index];
    table.uses_of_set[ref.uv_set] |= 1u << use;
  }
  return table;
}

}  // namespace tessera::core
