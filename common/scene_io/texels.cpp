// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/texels.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

std::size_t first_of(const Texture& texture, int x, int y) {
  return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width_px) +
              static_cast<std::size_t>(x));
}

template <typename Texel>
bool all_grey(const std::vector<Texel>& rgba) {
  for (std::size_t i = 0; i + 3 < rgba.size(); i += 4) {
    if (rgba[i] != rgba[i + 1] || rgba[i] != rgba[i + 2]) return false;
  }
  return true;
}

template <typename Texel>
bool any_alpha(const std::vector<Texel>& rgba) {
  for (std::size_t i = 3; i < rgba.size(); i += 4) {
    if (rgba[i] != static_cast<Texel>(~Texel{0})) return true;
  }
  return false;
}

int beyond_edge(int at, int count, TextureWrap wrap) {
  if (at >= 0 && at < count) return at;
  if (wrap == TextureWrap::kRepeat) return at < 0 ? at + count : at - count;
  return std::clamp(at, 0, count - 1);  // the edge's texel twice, also where it is mirrored
}

}  // namespace

float texel_at(const Texture& texture, int x, int y, int channel) {
  const std::size_t at = first_of(texture, x, y) + static_cast<std::size_t>(channel);
  return texture.rgba16.empty() ? static_cast<float>(texture.rgba[at]) / 255.0f
                                : static_cast<float>(texture.rgba16[at]) / 65535.0f;
}

float luminance_at(const Texture& texture, int x, int y) {
  return 0.2126f * texel_at(texture, x, y, 0) + 0.7152f * texel_at(texture, x, y, 1) +
         0.0722f * texel_at(texture, x, y, 2);
}

bool is_grey(const Texture& texture) { return all_grey(texture.rgba) && all_grey(texture.rgba16); }
bool has_alpha(const Texture& texture) {
  return any_alpha(texture.rgba) || any_alpha(texture.rgba16);
}

bool is_normal_map(const Texture& texture) {
  // Filters and compression shorten normals by a tenth or so; of random colours half are that far
  // off. A sample of texels, some 256 in a row, is enough.
  std::size_t count = 0, directions = 0;
  double outward = 0;
  const int step = std::max(1, std::max(texture.width_px, texture.height_px) / 256);
  for (int y = 0; y < texture.height_px; y += step) {
    for (int x = 0; x < texture.width_px; x += step) {
      const Vec3f n{2 * texel_at(texture, x, y, 0) - 1, 2 * texel_at(texture, x, y, 1) - 1,
                    2 * texel_at(texture, x, y, 2) - 1};
      ++count;
      outward += double{n.z};
      if (std::abs(length(n) - 1) < 0.15f && n.z > 0) ++directions;
    }
  }
  return !is_grey(texture) && directions * 10 >= count * 9 &&
         outward >= 0.5 * static_cast<double>(count);
}

std::shared_ptr<Texture> make_texture(
    const Texture& like, int width_px, int height_px,
    const std::function<float(int x, int y, int channel)>& value) {
  auto made = std::make_shared<Texture>();
  made->width_px = width_px;
  made->height_px = height_px;
  made->is_srgb = false;
  made->wrap_u = like.wrap_u;
  made->wrap_v = like.wrap_v;
  made->is_nearest = like.is_nearest;
  const bool is_deep = !like.rgba16.empty();
  const std::size_t values =
      4 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  is_deep ? made->rgba16.resize(values) : made->rgba.resize(values);
  std::size_t at = 0;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      for (int channel = 0; channel < 4; ++channel, ++at) {
        const float share = std::clamp(value(x, y, channel), 0.0f, 1.0f);
        if (is_deep) {
          made->rgba16[at] = static_cast<std::uint16_t>(std::lround(share * 65535));
        } else {
          made->rgba[at] = static_cast<std::uint8_t>(std::lround(share * 255));
        }
      }
    }
  }
  return made;
}

std::shared_ptr<Texture> normals_of_heights(const Texture& heights, float bump) {
  const int width = heights.width_px, height = heights.height_px;
  std::vector<float> level(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto index = [width](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) level[index(x, y)] = luminance_at(heights, x, y);
  }
  const auto at = [&](int x, int y) {
    return level[index(beyond_edge(x, width, heights.wrap_u),
                       beyond_edge(y, height, heights.wrap_v))];
  };
  // The whole height in texels, divided by the two texels and the weights 1, 2, 1 of a slope.
  const float scale = kBumpHeight * bump * static_cast<float>(std::max(width, height)) / 8;
  Vec3f normal;
  return make_texture(heights, width, height, [&](int x, int y, int channel) {
    if (channel == 0) {
      const float right = at(x + 1, y - 1) + 2 * at(x + 1, y) + at(x + 1, y + 1);
      const float left = at(x - 1, y - 1) + 2 * at(x - 1, y) + at(x - 1, y + 1);
      const float above = at(x - 1, y - 1) + 2 * at(x, y - 1) + at(x + 1, y - 1);
      const float below = at(x - 1, y + 1) + 2 * at(x, y + 1) + at(x + 1, y + 1);
      normal = normalize(Vec3f{-scale * (right - left), -scale * (above - below), 1});
    }
    return channel == 3 ? 1 : 0.5f * normal[channel] + 0.5f;
  });
}

}  // namespace tessera
