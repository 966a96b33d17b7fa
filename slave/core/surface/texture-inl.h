// SPDX-License-Identifier: Apache-2.0
// Texture lookups, a point to a lane: trilinear between mip levels (Williams, "Pyramidal
// parametrics", 1983), bilinear within them, or nearest in the texture itself. Texels are fetched
// one by one, for gathers are no faster; everything else is done in registers.
//
// The level is the exponent of the footprint's width plus its linear mantissa, off from the
// logarithm by 0.09 at most, and needs no library logarithm, whose last bits depend on the
// processor.
//
// Threads. Pure functions.
#include <string.h>

#include "slave/core/surface/texture_layout.h"

#if defined(TESSERA_CORE_TEXTURE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TEXTURE_INL_H_
#undef TESSERA_CORE_TEXTURE_INL_H_
#else
#define TESSERA_CORE_TEXTURE_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Where the points of a register look at textures.
class TextureLookup {
  using V = Floats;
  using VI = Ints;
  using VU = Uints;

 public:
  // u, v: any number; one that is not finite gives some texel. images: how many images the
  // footprint is wide, in a square one. Up to a width of one texel the texture itself is looked up;
  // infinity and NaN give the last level. lanes: how many lanes are points.
  HWY_INLINE TextureLookup(V u, V v, V images, size_t lanes)
      : u_(u), v_(1 - v), images_(images), lanes_(lanes) {}

  // Linear values of the first kChannels channels, from 0 red to 3 alpha.
  template <size_t kChannels>
  struct Texel {
    V channel[kChannels];
    HWY_INLINE Vec3<V> rgb() const { return {channel[0], channel[1], channel[2]}; }
  };

  template <size_t kChannels>
  HWY_INLINE Texel<kChannels> sample(const TextureView& texture) const {
    const float texel_count =
        static_cast<float>(texture.width) * static_cast<float>(texture.height);
    const V texels = images_ * sqrt(set<V>(texel_count));
    const V end = set<V>(static_cast<float>(1u << texture.last));
    const auto is_within = texels > 1 && texels < end;
    const auto is_fine = texels <= 1;
    const VI bits = bit_cast<VI>(texels), last = set<VI>(texture.last);
    const VI exponent = shift_right<23>(bits) - 127;
    const VI whole = zero_if(is_fine, last);
    const VI lower = select(is_within, exponent, whole);
    const VI mantissa = (bits & 0x007fffff) | 0x3f800000;  // in [1, 2)
    const V weight = zero_unless(is_within, bit_cast<V>(mantissa) - 1);
    const Texel<kChannels> sharper = interpolated<kChannels>(texture, lower);
    if (is_none<V>(weight != 0)) return sharper;
    const VI upper = min(lower + 1, last);
    return mixed(sharper, interpolated<kChannels>(texture, upper), weight);
  }

 private:
  // The two texels of one axis around a coordinate and the weight of the second.
  struct Taps {
    VI first, second;
    V weight;
  };

  template <size_t kChannels>
  static HWY_INLINE Texel<kChannels> mixed(const Texel<kChannels>& a, const Texel<kChannels>& b,
                                           V t) {
    const V rest = 1 - t;
    Texel<kChannels> sum;
    for (size_t c = 0; c < kChannels; ++c) sum.channel[c] = a.channel[c] * rest + b.channel[c] * t;
    return sum;
  }

  // The coordinate wrapped to [0, 1]; 1 by rounding of tiny negatives, 0 where it is not finite.
  static HWY_INLINE V repeated(V c) {
    const V wrapped = c - floor(c);
    return zero_unless(wrapped >= 0, wrapped);
  }

  // back: half a texel, or 0 where the nearest texel is asked for.
  static HWY_INLINE Taps repeating_taps(V c, VI size, V back) {
    const V at = repeated(c) * convert<V>(size) - back;
    const V base = floor(at);
    const VI whole = convert<VI>(base);  // -1 .. size
    const VI first = zero_unless(whole < size, whole);
    const VI next = whole + 1;
    const auto is_before = whole < 0;
    return {select(is_before, size - 1, first), zero_unless(next < size, next), at - base};
  }

  static HWY_INLINE Taps clamped_taps(V c, VI size, V back) {
    const VI last = size - 1;
    const V end = convert<V>(last);
    const V at = c * convert<V>(size) - back;
    const V low = zero_unless(at >= 0, at);  // NaN is 0
    const V within = select(low < end, low, end);
    const V base = floor(within);
    const VI first = convert<VI>(base);
    return {first, min(first + 1, last), within - base};
  }

  static HWY_INLINE Taps wrapped_taps(EdgeWrap wrap, V c, VI size, V back) {
    if (wrap == EdgeWrap::kRepeat) return repeating_taps(c, size, back);
    if (wrap == EdgeWrap::kClamp) return clamped_taps(c, size, back);
    const V once = repeated(c * 0.5f), twice = once + once;
    const V there = select(twice <= 1, twice, 2 - twice);
    return clamped_taps(there, size, back);
  }

  // is_nearest: lanes that ask for one texel.
  static HWY_INLINE Taps taps_of(EdgeWrap wrap, V c, VI size, MaskOf<V> is_nearest) {
    Taps taps = wrapped_taps(wrap, c, size, zero_if(is_nearest, set<V>(0.5f)));
    taps.weight = zero_if(is_nearest, taps.weight);
    return taps;
  }

  // Interpolates between the texels of a level.
  template <size_t kChannels>
  HWY_INLINE Texel<kChannels> interpolated(const TextureView& texture, VI level) const {
    const auto side_of = [&](int32_t whole) { return max(set<VI>(whole) >> level, 1); };
    const VI width = side_of(texture.width), height = side_of(texture.height);
    // Level that is not interpolated; no lane of most textures has it.
    const VI none = set<VI>(texture.is_nearest ? 0 : -1);
    const auto is_nearest = mask_as<V>(level == none);
    const Taps x = taps_of(texture.wrap_u, u_, width, is_nearest);
    const Taps y = taps_of(texture.wrap_v, v_, height, is_nearest);
    const VI top = y.first * width, bottom = y.second * width;
    Texels texels;
    store(level, texels.level);
    store(top + x.first, texels.index[0]);
    store(top + x.second, texels.index[1]);
    store(bottom + x.first, texels.index[2]);
    store(bottom + x.second, texels.index[3]);
    texels.fetch(texture, lanes_);
    const auto texel = [&](size_t k) { return decoded<kChannels>(texture, texels, k); };
    return mixed(mixed(texel(0), texel(1), x.weight), mixed(texel(2), texel(3), x.weight),
                 y.weight);
  }

  // The four texels of each point; `high`: the upper two channels, where they are wide.
  struct Texels {
    alignas(64) int32_t level[kLaneCount];
    alignas(64) int32_t index[4][kLaneCount];
    alignas(64) uint32_t low[4][kLaneCount];
    alignas(64) uint32_t high[4][kLaneCount];

    HWY_INLINE void fetch(const TextureView& texture, size_t lanes) {
      if (texture.is_wide) return fetch_wide(texture, lanes);
      for (size_t lane = 0; lane < lanes; ++lane) {
        const uint8_t* const of = static_cast<const uint8_t*>(texture.level[level[lane]]);
        for (size_t k = 0; k < 4; ++k)
          memcpy(&low[k][lane], of + 4 * static_cast<size_t>(index[k][lane]), 4);
      }
      for (size_t lane = lanes; lane < kLaneCount; ++lane) {
        for (size_t k = 0; k < 4; ++k) low[k][lane] = 0;
      }
    }
    HWY_INLINE void fetch_wide(const TextureView& texture, size_t lanes) {
      for (size_t lane = 0; lane < kLaneCount; ++lane) {
        for (size_t k = 0; k < 4; ++k) {
          low[k][lane] = high[k][lane] = 0;
          if (lane >= lanes) continue;
          const uint8_t* const of = static_cast<const uint8_t*>(texture.level[level[lane]]) +
                                    8 * static_cast<size_t>(index[k][lane]);
          memcpy(&low[k][lane], of, 4);
          memcpy(&high[k][lane], of + 4, 4);
        }
      }
    }
  };

  template <size_t kChannels>
  static HWY_INLINE Texel<kChannels> decoded(const TextureView& texture, const Texels& texels,
                                             size_t k) {
    const VU low = load<VU>(texels.low[k]);
    const auto value = [&](size_t c, VU shifted, uint32_t highest) {
      const VI whole = bit_cast<VI>(shifted & highest);
      if (c < 3 && texture.srgb_table != nullptr) return gather(texture.srgb_table, whole);
      return convert<V>(whole) * (1 / static_cast<float>(highest));
    };
    Texel<kChannels> texel;
    if (texture.is_wide) {
      const VU high = load<VU>(texels.high[k]);
      const VU shifted[4] = {low, shift_right<16>(low), high, shift_right<16>(high)};
      for (size_t c = 0; c < kChannels; ++c) texel.channel[c] = value(c, shifted[c], 65535);
    } else {
      const VU shifted[4] = {low, shift_right<8>(low), shift_right<16>(low), shift_right<24>(low)};
      for (size_t c = 0; c < kChannels; ++c) texel.channel[c] = value(c, shifted[c], 255);
    }
    return texel;
  }

  V u_, v_;  // v from the top
  V images_;
  size_t lanes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
