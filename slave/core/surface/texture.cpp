// SPDX-License-Identifier: Apache-2.0
#include "slave/core/surface/texture.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace tessera::core {
namespace {

static_assert(static_cast<int>(EdgeWrap::kRepeat) == static_cast<int>(TextureWrap::kRepeat));
static_assert(static_cast<int>(EdgeWrap::kMirror) == static_cast<int>(TextureWrap::kMirror));
static_assert(static_cast<int>(EdgeWrap::kClamp) == static_cast<int>(TextureWrap::kClamp));

constexpr std::uint32_t kAlpha = 3;

// sRGB to linear, IEC 61966-2-1. Computed in double, so that the floats do not depend on the
// processor.
std::vector<float> make_srgb_table(std::size_t count) {
  std::vector<float> table(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double e = static_cast<double>(i) / static_cast<double>(count - 1);
    table[i] = static_cast<float>(e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4));
  }
  return table;
}

// What the integers of a channel mean.
template <class Integer>
struct Encoding {
  static constexpr float kHighest = static_cast<float>(static_cast<Integer>(-1));

  static const std::vector<float>& srgb_table() {
    static const std::vector<float> kLinear =
        make_srgb_table(std::size_t{1} << 8 * sizeof(Integer));
    return kLinear;
  }
  static float decoded(Integer value, bool is_srgb) {
    return is_srgb ? srgb_table()[value] : static_cast<float>(value) * (1 / kHighest);
  }
  // Returns: the integer that decodes nearest to `linear`.
  static Integer encoded(float linear, bool is_srgb) {
    if (!is_srgb) return static_cast<Integer>(std::clamp(linear * kHighest + 0.5f, 0.0f, kHighest));
    const auto& table = srgb_table();
    const auto above = std::lower_bound(table.begin(), table.end(), linear);
    if (above == table.begin()) return 0;
    if (above == table.end()) return static_cast<Integer>(-1);
    const auto i = static_cast<Integer>(above - table.begin());
    return linear - *(above - 1) < *above - linear ? static_cast<Integer>(i - 1) : i;
  }
};

// Calls `function` with the texels of the array that is filled.
template <class Function>
auto with_texels(const Texture& texture, const Function& function) {
  return texture.rgba16.empty() ? function(std::span<const std::uint8_t>(texture.rgba))
                                : function(std::span<const std::uint16_t>(texture.rgba16));
}

std::size_t texel_index(const Texture& texture, int x, int y) {
  return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width_px) +
              static_cast<std::size_t>(x));
}

template <class Integer>
Vec3f rgb_at(const Texture& t, std::span<const Integer> texels, int x, int y) {
  const Integer* const p = texels.data() + texel_index(t, x, y);
  if (t.is_srgb) {
    const auto& table = Encoding<Integer>::srgb_table();
    return {table[p[0]], table[p[1]], table[p[2]]};
  }
  return Vec3f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])} *
         (1 / Encoding<Integer>::kHighest);
}

template <class Integer>
float channel_at(const Texture& t, std::span<const Integer> texels, std::uint32_t channel, int x,
                 int y) {
  return Encoding<Integer>::decoded(texels[texel_index(t, x, y) + channel],
                                    t.is_srgb && channel != kAlpha);
}

// The two texels of one axis around coordinate c (in images) and the weight of the second.
struct Taps {
  int first, second;
  float weight;
};

// The coordinate wrapped to [0, 1]; 0 where it is not finite, since interpolation of huge numbers
// overflows.
float repeated(float c) {
  const float wrapped = c - std::floor(c);  // 1 by rounding of tiny negatives
  return wrapped >= 0 ? wrapped : 0;
}

Taps repeating_taps(float c, int size, bool is_nearest) {
  const float at = repeated(c) * static_cast<float>(size) - (is_nearest ? 0 : 0.5f);
  const float base = std::floor(at);
  const int first = static_cast<int>(base);  // -1 .. size
  if (is_nearest) return {first % size, first % size, 0};
  return {(first + size) % size, (first + 1 + size) % size, at - base};
}

Taps clamped_taps(float c, int size, bool is_nearest) {
  const float at = c * static_cast<float>(size) - (is_nearest ? 0 : 0.5f);
  const float end = static_cast<float>(size - 1);
  const float within = at >= 0 ? (at < end ? at : end) : 0;
  const float base = std::floor(within);
  const int first = static_cast<int>(base);
  if (is_nearest) return {first, first, 0};
  return {first, std::min(first + 1, size - 1), within - base};
}

Taps taps_of(float c, int size, TextureWrap wrap, bool is_nearest) {
  if (wrap == TextureWrap::kRepeat) return repeating_taps(c, size, is_nearest);
  if (wrap == TextureWrap::kClamp) return clamped_taps(c, size, is_nearest);
  const float twice = 2 * repeated(c / 2);  // there and back
  return clamped_taps(twice <= 1 ? twice : 2 - twice, size, is_nearest);
}

// at(x, y): value of a texel.
template <class At>
auto interpolated(const Texture& t, Vec2f uv, const At& at) {
  const Taps x = taps_of(uv.x, t.width_px, t.wrap_u, t.is_nearest);
  const Taps y = taps_of(1 - uv.y, t.height_px, t.wrap_v, t.is_nearest);
  const auto top = at(x.first, y.first) * (1 - x.weight) + at(x.second, y.first) * x.weight;
  const auto bottom = at(x.first, y.second) * (1 - x.weight) + at(x.second, y.second) * x.weight;
  return top * (1 - y.weight) + bottom * y.weight;
}

// Value: Vec3f for RGB, or float for alpha.
template <class Value>
struct Pixels {
  int width = 0, height = 0;
  std::vector<Value> values;
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

// at(x, y): value of a texel that is halved.
template <class Value, class At>
Pixels<Value> halved(int width, int height, const At& at) {
  Pixels<Value> to{std::max(1, width / 2), std::max(1, height / 2), {}};
  to.values.resize(to.index(0, to.height));
  for (int y = 0; y < to.height; ++y) {
    const Cover rows = cover_of(y, height, to.height);
    for (int x = 0; x < to.width; ++x) {
      const Cover columns = cover_of(x, width, to.width);
      Value sum{};
      for (int j = 0; j < rows.count; ++j) {
        for (int i = 0; i < columns.count; ++i)
          sum = sum + at(columns.first + i, rows.first + j) * (rows.weight[j] * columns.weight[i]);
      }
      to.values[to.index(x, y)] = sum;
    }
  }
  return to;
}

// Halves down to 1 x 1. at(x, y): value of a texel of the base; keep(pixels, i): takes level i + 1.
template <class Value, class At, class Keep>
void halve_all(const Texture& base, const At& at, const Keep& keep) {
  if (base.width_px == 1 && base.height_px == 1) return;
  Pixels<Value> pixels = halved<Value>(base.width_px, base.height_px, at);
  keep(pixels, std::size_t{0});
  for (std::size_t level = 1; pixels.width > 1 || pixels.height > 1; ++level) {
    pixels = halved<Value>(pixels.width, pixels.height,
                           [&pixels](int x, int y) { return pixels.values[pixels.index(x, y)]; });
    keep(pixels, level);
  }
}

std::vector<std::uint8_t>& texels_of(Texture& t, std::uint8_t) { return t.rgba; }
std::vector<std::uint16_t>& texels_of(Texture& t, std::uint16_t) { return t.rgba16; }

// Makes levels of RGB first, and of alpha, where there is any, after that, so that no more floats
// are held at a time than those of one of them.
template <class Integer>
void add_levels(const Texture& base, std::span<const Integer> texels, MipMap& map) {
  using Encoded = Encoding<Integer>;
  const auto add_rgb = [&](const Pixels<Vec3f>& pixels, std::size_t) {
    Texture level;
    level.width_px = pixels.width;
    level.height_px = pixels.height;
    level.is_srgb = base.is_srgb;
    level.wrap_u = base.wrap_u;
    level.wrap_v = base.wrap_v;
    auto& to = texels_of(level, Integer{});
    to.reserve(4 * pixels.values.size());
    for (const Vec3f& c : pixels.values) {
      for (int a = 0; a < 3; ++a) to.push_back(Encoded::encoded(c[a], base.is_srgb));
      to.push_back(static_cast<Integer>(-1));
    }
    map.levels.push_back(std::move(level));
  };
  halve_all<Vec3f>(
      base, [&](int x, int y) { return rgb_at(base, texels, x, y); }, add_rgb);
  if (is_full(base, kAlpha)) return;
  const auto set_alpha = [&](const Pixels<float>& pixels, std::size_t level) {
    auto& to = texels_of(map.levels[level], Integer{});
    for (std::size_t i = 0; i < pixels.values.size(); ++i)
      to[4 * i + kAlpha] = Encoded::encoded(pixels.values[i], false);
  };
  halve_all<float>(
      base, [&](int x, int y) { return channel_at(base, texels, kAlpha, x, y); }, set_alpha);
}

const void* first_texel(const Texture& t) {
  return t.rgba16.empty() ? static_cast<const void*>(t.rgba.data()) : t.rgba16.data();
}

}  // namespace

MipMap make_mip_map(std::shared_ptr<const Texture> texture) {
  MipMap map{std::move(texture), {}};
  with_texels(*map.base, [&](auto texels) { add_levels(*map.base, texels, map); });
  return map;
}

Vec3f sample_texture(const Texture& t, Vec2f uv) {
  return with_texels(t, [&](auto texels) {
    return interpolated(t, uv, [&](int x, int y) { return rgb_at(t, texels, x, y); });
  });
}

float sample_channel(const Texture& t, Vec2f uv, std::uint32_t channel) {
  return with_texels(t, [&](auto texels) {
    return interpolated(t, uv, [&](int x, int y) { return channel_at(t, texels, channel, x, y); });
  });
}

bool is_full(const Texture& texture, std::uint32_t channel) {
  return with_texels(texture, [&](auto texels) {
    using Integer = typename decltype(texels)::value_type;
    for (std::size_t i = channel; i < texels.size(); i += 4) {
      if (texels[i] != static_cast<Integer>(-1)) return false;
    }
    return true;
  });
}

TextureView view_of(const MipMap& map) {
  TextureView view{};
  const Texture& base = *map.base;
  view.level[0] = first_texel(base);
  for (std::size_t i = 0; i < map.levels.size(); ++i)
    view.level[i + 1] = first_texel(map.levels[i]);
  view.width = base.width_px;
  view.height = base.height_px;
  view.last = static_cast<std::int32_t>(map.levels.size());
  view.is_wide = base.rgba.empty();
  view.is_nearest = base.is_nearest;
  view.wrap_u = static_cast<EdgeWrap>(base.wrap_u);
  view.wrap_v = static_cast<EdgeWrap>(base.wrap_v);
  if (base.is_srgb) {
    view.srgb_table = view.is_wide ? Encoding<std::uint16_t>::srgb_table().data()
                                   : Encoding<std::uint8_t>::srgb_table().data();
  }
  return view;
}

std::uint64_t memory_bytes_of(const Texture& texture) {
  return texture.rgba.size() + texture.rgba16.size() * sizeof(std::uint16_t);
}

}  // namespace tessera::core
