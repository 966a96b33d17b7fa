#include "slave/core/surface/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::core {
namespace {

// sRGB byte to linear, IEC 61966-2-1. From double, so that the floats do not depend on the
// processor.
std::array<float, 256> make_srgb_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double e = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4));
  }
  return table;
}

const std::array<float, 256>& srgb_table() {
  static const std::array<float, 256> kLinear = make_srgb_table();
  return kLinear;
}

Vec3f decoded(const std::uint8_t* p, bool is_srgb) {
  if (is_srgb) return {srgb_table()[p[0]], srgb_table()[p[1]], srgb_table()[p[2]]};
  return Vec3f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])} *
         (1 / 255.0f);
}

// The byte that decodes nearest to it.
std::uint8_t encoded(float linear, bool is_srgb) {
  if (!is_srgb) return static_cast<std::uint8_t>(std::clamp(linear * 255 + 0.5f, 0.0f, 255.0f));
  const auto& table = srgb_table();
  const auto above = std::lower_bound(table.begin(), table.end(), linear);
  if (above == table.begin()) return 0;
  if (above == table.end()) return 255;
  const auto i = static_cast<std::uint8_t>(above - table.begin());
  return linear - *(above - 1) < *above - linear ? static_cast<std::uint8_t>(i - 1) : i;
}

Vec3f texel(const Texture& texture, int x, int y) {
  const std::size_t index =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width_px) +
           static_cast<std::size_t>(x));
  return decoded(texture.rgba.data() + index, texture.is_srgb);
}

// The two texels of one axis around coordinate c (in images) and the weight of the second.
struct Taps {
  int first, second;
  float weight;
};

Taps taps_of(float c, int size) {
  float wrapped = c - std::floor(c);  // in [0, 1]; 1 by rounding of tiny negatives
  if (!(wrapped >= 0)) wrapped = 0;   // interpolation of huge numbers overflows
  const float at = wrapped * static_cast<float>(size) - 0.5f;
  const float base = std::floor(at);
  const int first = static_cast<int>(base);  // -1 .. size
  return {(first + size) % size, (first + 1 + size) % size, at - base};
}

struct Pixels {
  int width, height;
  std::vector<Vec3f> values;
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

// Which of `from` texels the i-th of `to` covers, and how much of each: two, or three where `from`
// is odd. The mean of the whole stays.
struct Cover {
  int first, count;
  float weight[3];
};

Cover cover_of(int i, int from, int to) {
  if (from == 1) return {0, 1, {1, 0, 0}};
  if (from % 2 == 0) return {2 * i, 2, {0.5f, 0.5f, 0}};
  const float n = static_cast<float>(to), whole = static_cast<float>(from);
  const float k = static_cast<float>(i);
  return {2 * i, 3, {(n - k) / whole, n / whole, (k + 1) / whole}};
}

// at(x, y): of what is halved.
template <class At>
Pixels halved(int width, int height, At at) {
  Pixels to{std::max(1, width / 2), std::max(1, height / 2), {}};
  to.values.resize(to.index(0, to.height));
  for (int y = 0; y < to.height; ++y) {
    const Cover rows = cover_of(y, height, to.height);
    for (int x = 0; x < to.width; ++x) {
      const Cover columns = cover_of(x, width, to.width);
      Vec3f sum;
      for (int j = 0; j < rows.count; ++j) {
        for (int i = 0; i < columns.count; ++i)
          sum = sum + at(columns.first + i, rows.first + j) * (rows.weight[j] * columns.weight[i]);
      }
      to.values[to.index(x, y)] = sum;
    }
  }
  return to;
}

Texture bytes_of(const Pixels& pixels, bool is_srgb) {
  Texture level{pixels.width, pixels.height, is_srgb, {}};
  level.rgba.reserve(4 * pixels.values.size());
  for (const Vec3f& c : pixels.values) {
    for (int a = 0; a < 3; ++a) level.rgba.push_back(encoded(c[a], is_srgb));
    level.rgba.push_back(255);
  }
  return level;
}

}  // namespace

MipMap make_mip_map(std::shared_ptr<const Texture> texture) {
  MipMap map{std::move(texture), {}};
  const Texture& base = *map.base;
  if (base.width_px == 1 && base.height_px == 1) return map;
  Pixels pixels =
      halved(base.width_px, base.height_px, [&base](int x, int y) { return texel(base, x, y); });
  map.levels.push_back(bytes_of(pixels, base.is_srgb));
  while (pixels.width > 1 || pixels.height > 1) {
    pixels = halved(pixels.width, pixels.height,
                    [&pixels](int x, int y) { return pixels.values[pixels.index(x, y)]; });
    map.levels.push_back(bytes_of(pixels, base.is_srgb));
  }
  return map;
}

Vec3f sample_texture(const Texture& texture, Vec2f uv) {
  const Taps x = taps_of(uv.x, texture.width_px), y = taps_of(1 - uv.y, texture.height_px);
  const Vec3f top = texel(texture, x.first, y.first) * (1 - x.weight) +
                    texel(texture, x.second, y.first) * x.weight;
  const Vec3f bottom = texel(texture, x.first, y.second) * (1 - x.weight) +
                       texel(texture, x.second, y.second) * x.weight;
  return top * (1 - y.weight) + bottom * y.weight;
}

TextureView view_of(const MipMap& map) {
  TextureView view{};
  const Texture& base = *map.base;
  view.level[0] = base.rgba.data();
  for (std::size_t i = 0; i < map.levels.size(); ++i) view.level[i + 1] = map.levels[i].rgba.data();
  view.width = base.width_px;
  view.height = base.height_px;
  view.last = static_cast<std::int32_t>(map.levels.size());
  view.srgb_table = base.is_srgb ? srgb_table().data() : nullptr;
  return view;
}

}  // namespace tessera::core
