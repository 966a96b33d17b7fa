// SPDX-License-Identifier: Apache-2.0
// Texture lookups, a point to a lane: trilinear between mip levels (Williams, "Pyramidal parametrics",
// 1983), bilinear within them, or nearest in the texture itself. Texels are fetched one by one, for
// gathers are no faster; everything else is done in registers.
//
// The level is the exponent of the footprint's width plus its linear mantissa, off from the logarithm
// by 0.09 at most, and needs no library logarithm, whose last bits depend on the processor.
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
  using D = hn::CappedTag<float, 16>;
  using DI = hn::RebindToSigned<D>;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;
  using VI = hn::Vec<DI>;
  using VU = hn::Vec<DU>;
  static constexpr size_t kLanes = hn::MaxLanes(D());

 public:
  // u, v: any number; what is not finite is some texel. images: how many images the footprint is
  // wide, in a square one; up to one texel it is the texture itself, infinity and NaN are the last
  // level. lanes: how many are points.
  HWY_INLINE TextureLookup(V u, V v, V images, size_t lanes)
      : u_(u), v_(hn::Sub(hn::Set(D(), 1), v)), images_(images), lanes_(lanes) {}

  // Linear; of channels 0 red to 3 alpha the first kChannels.
  template <size_t kChannels>
  struct Texel {
    V channel[kChannels];
    HWY_INLINE Vec3<D> rgb() const { return {channel[0], channel[1], channel[2]}; }
  };

  template <size_t kChannels>
  HWY_INLINE Texel<kChannels> sample(const TextureView& texture) const {
    const D d;
    const DI di;
    const float texel_count =
        static_cast<float>(texture.width) * static_cast<float>(texture.height);
    const V texels = hn::Mul(images_, hn::Sqrt(hn::Set(d, texel_count)));
    const V end = hn::Set(d, static_cast<float>(1u << texture.last));
    const auto is_within = hn::And(hn::Gt(texels, hn::Set(d, 1)), hn::Lt(texels, end));
    const auto is_fine = hn::Le(texels, hn::Set(d, 1));
    const VI bits = hn::BitCast(di, texels), last = hn::Set(di, texture.last);
    const VI exponent = hn::Sub(hn::ShiftRight<23>(bits), hn::Set(di, 127));
    const VI whole = hn::IfThenZeroElse(hn::RebindMask(di, is_fine), last);
    const VI lower = hn::IfThenElse(hn::RebindMask(di, is_within), exponent, whole);
    const VI one = hn::Set(di, 0x3f800000);
    const VI mantissa = hn::Or(hn::And(bits, hn::Set(di, 0x007fffff)), one);
    const V weight =
        hn::IfThenElseZero(is_within, hn::Sub(hn::BitCast(d, mantissa), hn::Set(d, 1)));
    const Texel<kChannels> sharper = interpolated<kChannels>(texture, lower);
    if (hn::AllFalse(d, hn::Ne(weight, hn::Zero(d)))) return sharper;
    const VI upper = hn::Min(hn::Add(lower, hn::Set(di, 1)), last);
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
    const V rest = hn::Sub(hn::Set(D(), 1), t);
    Texel<kChannels> sum;
    for (size_t c = 0; c < kChannels; ++c)
      sum.channel[c] = hn::Add(hn::Mul(a.channel[c], rest), hn::Mul(b.channel[c], t));
    return sum;
  }

  // In [0, 1], 1 by rounding of tiny negatives; 0 for NaN, which is what is not finite.
  static HWY_INLINE V repeated(V c) {
    const V wrapped = hn::Sub(c, hn::Floor(c));
    return hn::IfThenElseZero(hn::Ge(wrapped, hn::Zero(D())), wrapped);
  }

  // back: half a texel, or nothing where the nearest is asked for.
  static HWY_INLINE Taps repeating_taps(V c, VI size, V back) {
    const D d;
    const DI di;
    const V at = hn::Sub(hn::Mul(repeated(c), hn::ConvertTo(d, size)), back);
    const V base = hn::Floor(at);
    const VI whole = hn::ConvertTo(di, base);  // -1 .. size
    const VI first = hn::IfThenElseZero(hn::Lt(whole, size), whole);
    const VI next = hn::Add(whole, hn::Set(di, 1));
    const auto is_before = hn::Lt(whole, hn::Zero(di));
    return {hn::IfThenElse(is_before, hn::Sub(size, hn::Set(di, 1)), first),
            hn::IfThenElseZero(hn::Lt(next, size), next), hn::Sub(at, base)};
  }

  static HWY_INLINE Taps clamped_taps(V c, VI size, V back) {
    const D d;
    const DI di;
    const VI last = hn::Sub(size, hn::Set(di, 1));
    const V end = hn::ConvertTo(d, last);
    const V at = hn::Sub(hn::Mul(c, hn::ConvertTo(d, size)), back);
    const V low = hn::IfThenElseZero(hn::Ge(at, hn::Zero(d)), at);  // NaN is 0
    const V within = hn::IfThenElse(hn::Lt(low, end), low, end);
    const V base = hn::Floor(within);
    const VI first = hn::ConvertTo(di, base);
    return {first, hn::Min(hn::Add(first, hn::Set(di, 1)), last), hn::Sub(within, base)};
  }

  static HWY_INLINE Taps wrapped_taps(EdgeWrap wrap, V c, VI size, V back) {
    const D d;
    if (wrap == EdgeWrap::kRepeat) return repeating_taps(c, size, back);
    if (wrap == EdgeWrap::kClamp) return clamped_taps(c, size, back);
    const V once = repeated(hn::Mul(c, hn::Set(d, 0.5f))), twice = hn::Add(once, once);
    const V one = hn::Set(d, 1);
    const V there = hn::IfThenElse(hn::Le(twice, one), twice, hn::Sub(hn::Add(one, one), twice));
    return clamped_taps(there, size, back);
  }

  // is_nearest: lanes of which one texel is asked for.
  static HWY_INLINE Taps taps_of(EdgeWrap wrap, V c, VI size, hn::Mask<D> is_nearest) {
    const V half = hn::Set(D(), 0.5f);
    Taps taps = wrapped_taps(wrap, c, size, hn::IfThenZeroElse(is_nearest, half));
    taps.weight = hn::IfThenZeroElse(is_nearest, taps.weight);
    return taps;
  }

  // Between the texels of a level.
  template <size_t kChannels>
  HWY_INLINE Texel<kChannels> interpolated(const TextureView& texture, VI level) const {
    const D d;
    const DI di;
    const auto side_of = [&](int32_t whole) {
      return hn::Max(hn::Shr(hn::Set(di, whole), level), hn::Set(di, 1));
    };
    const VI width = side_of(texture.width), height = side_of(texture.height);
    // No lane of most textures.
    const VI none = hn::Set(di, texture.is_nearest ? 0 : -1);
    const auto is_nearest = hn::RebindMask(d, hn::Eq(level, none));
    const Taps x = taps_of(texture.wrap_u, u_, width, is_nearest);
    const Taps y = taps_of(texture.wrap_v, v_, height, is_nearest);
    const VI top = hn::Mul(y.first, width), bottom = hn::Mul(y.second, width);
    Texels texels;
    hn::Store(level, di, texels.level);
    hn::Store(hn::Add(top, x.first), di, texels.index[0]);
    hn::Store(hn::Add(top, x.second), di, texels.index[1]);
    hn::Store(hn::Add(bottom, x.first), di, texels.index[2]);
    hn::Store(hn::Add(bottom, x.second), di, texels.index[3]);
    texels.fetch(texture, lanes_);
    const auto texel = [&](size_t k) { return decoded<kChannels>(texture, texels, k); };
    return mixed(mixed(texel(0), texel(1), x.weight), mixed(texel(2), texel(3), x.weight),
                 y.weight);
  }

  // The four of each point; `high`: the upper two of wide channels.
  struct Texels {
    alignas(64) int32_t level[kLanes];
    alignas(64) int32_t index[4][kLanes];
    alignas(64) uint32_t low[4][kLanes];
    alignas(64) uint32_t high[4][kLanes];

    HWY_INLINE void fetch(const TextureView& texture, size_t lanes) {
      if (texture.is_wide) return fetch_wide(texture, lanes);
      for (size_t lane = 0; lane < lanes; ++lane) {
        const uint8_t* const of = static_cast<const uint8_t*>(texture.level[level[lane]]);
        for (size_t k = 0; k < 4; ++k)
          memcpy(&low[k][lane], of + 4 * static_cast<size_t>(index[k][lane]), 4);
      }
      for (size_t lane = lanes; lane < kLanes; ++lane) {
        for (size_t k = 0; k < 4; ++k) low[k][lane] = 0;
      }
    }
    HWY_INLINE void fetch_wide(const TextureView& texture, size_t lanes) {
      for (size_t lane = 0; lane < kLanes; ++lane) {
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
    const D d;
    const DI di;
    const DU du;
    const VU low = hn::Load(du, texels.low[k]);
    const auto value = [&](size_t c, VU shifted, uint32_t highest) {
      const VI whole = hn::BitCast(di, hn::And(shifted, hn::Set(du, highest)));
      if (c < 3 && texture.srgb_table != nullptr)
        return hn::GatherIndex(d, texture.srgb_table, whole);
      return hn::Mul(hn::ConvertTo(d, whole), hn::Set(d, 1 / static_cast<float>(highest)));
    };
    Texel<kChannels> texel;
    if (texture.is_wide) {
      const VU high = hn::Load(du, texels.high[k]);
      const VU shifted[4] = {low, hn::ShiftRight<16>(low), high, hn::ShiftRight<16>(high)};
      for (size_t c = 0; c < kChannels; ++c) texel.channel[c] = value(c, shifted[c], 65535);
    } else {
      const VU shifted[4] = {low, hn::ShiftRight<8>(low), hn::ShiftRight<16>(low),
                             hn::ShiftRight<24>(low)};
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
