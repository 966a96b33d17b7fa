// SPDX-License-Identifier: Apache-2.0
#include "slave/core/light/emitter_texture.h"

#include <algorithm>

namespace tessera::core {
namespace {

// A rectangle in texture coordinates.
struct Box {
  float left, width, low, height;
};

Box box_of(const EmitterTexture& at) {
  const float left = std::min({at.uv_a.x, at.uv_b.x, at.uv_c.x});
  const float low = std::min({at.uv_a.y, at.uv_b.y, at.uv_c.y});
  return {left, std::max({at.uv_a.x, at.uv_b.x, at.uv_c.x}) - left, low,
          std::max({at.uv_a.y, at.uv_b.y, at.uv_c.y}) - low};
}

// Whether all that lookups in the box can find is black. Returns false, too, where there are too
// many texels to look at.
bool is_dark(const Texture& texture, const Box& box) {
  constexpr float kTexelsMax = 65536;
  const float columns = box.width * static_cast<float>(texture.width_px) + 3;
  const float rows = box.height * static_cast<float>(texture.height_px) + 3;
  if (!(columns * rows <= kTexelsMax)) return false;
  for (int y = 0; y < static_cast<int>(rows); ++y) {
    for (int x = 0; x < static_cast<int>(columns); ++x) {
      const Vec2f uv{box.left + (static_cast<float>(x) - 1) / static_cast<float>(texture.width_px),
                     box.low + (static_cast<float>(y) - 1) / static_cast<float>(texture.height_px)};
      if (!is_black(sample_texture(texture, uv))) return false;
    }
  }
  return true;
}

}  // namespace

Vec3f mean_over(const MipMap& map, const EmitterTexture& at) {
  const auto [left, width, low, height] = box_of(at);
  static constexpr float kTexelsMax = 4;
  std::size_t level = 0;
  const auto texture = [&]() -> const Texture& {
    return level == 0 ? *map.base : map.levels[level - 1];
  };
  while (level < map.levels.size() &&
         !(width * static_cast<float>(texture().width_px) <= kTexelsMax &&
           height * static_cast<float>(texture().height_px) <= kTexelsMax))
    ++level;
  // A box of more than the whole picture gets the one texel of the last level.
  const auto count_of = [](float extent, int texels) {
    return static_cast<int>(std::min(extent * static_cast<float>(texels), kTexelsMax)) + 2;
  };
  const int columns = count_of(width, texture().width_px);
  const int rows = count_of(height, texture().height_px);
  Vec3f sum;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const float u = left + width * static_cast<float>(x) / static_cast<float>(columns - 1);
      const float v = low + height * static_cast<float>(y) / static_cast<float>(rows - 1);
      sum = sum + sample_texture(texture(), {u, v});
    }
  }
  if (!is_black(sum)) return sum * (1 / static_cast<float>(columns * rows));
  constexpr float kHalfByte = 1.5e-4f;  // half the least byte of sRGB, linear
  return is_dark(*map.base, box_of(at)) ? Vec3f{} : Vec3f{kHalfByte, kHalfByte, kHalfByte};
}

}  // namespace tessera::core
