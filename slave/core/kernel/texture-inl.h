// Texture lookups, a point to a lane: trilinear between mip levels (Williams, "Pyramidal parametrics",
// 1983), bilinear within them, repeating. Texels are fetched one by one, for gathers are no faster;
// everything else is done in registers.
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

#include "slave/core/kernel/vec3-inl.h"

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

  // Linear RGB.
  HWY_INLINE Vec3<D> sample(const TextureView& texture) const {
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
    const Vec3<D> sharper = bilinear(texture, lower);
    if (hn::AllFalse(d, hn::Ne(weight, hn::Zero(d)))) return sharper;
    const Vec3<D> coarser = bilinear(texture, hn::Min(hn::Add(lower, hn::Set(di, 1)), last));
    return sharper * hn::Sub(hn::Set(d, 1), weight) + coarser * weight;
  }

 private:
  // The two texels of one axis around a coordinate and the weight of the second.
  struct Taps {
    VI first, second;
    V weight;
  };

  static HWY_INLINE Taps taps_of(V c, VI size) {
    const D d;
    const DI di;
    const V wrapped = hn::Sub(c, hn::Floor(c));  // in [0, 1]; 1 by rounding of tiny negatives
    const V in = hn::IfThenElseZero(hn::Ge(wrapped, hn::Zero(d)), wrapped);  // NaN: not finite
    const V at = hn::Sub(hn::Mul(in, hn::ConvertTo(d, size)), hn::Set(d, 0.5f));
    const V base = hn::Floor(at);
    const VI first = hn::ConvertTo(di, base);  // -1 .. size - 1
    const VI next = hn::Add(first, hn::Set(di, 1));
    const auto is_before = hn::Lt(first, hn::Zero(di));
    return {hn::IfThenElse(is_before, hn::Sub(size, hn::Set(di, 1)), first),
            hn::IfThenElseZero(hn::Lt(next, size), next), hn::Sub(at, base)};
  }

  HWY_INLINE Vec3<D> bilinear(const TextureView& texture, VI level) const {
    const D d;
    const DI di;
    const auto side_of = [&](int32_t whole) {
      return hn::Max(hn::Shr(hn::Set(di, whole), level), hn::Set(di, 1));
    };
    const VI width = side_of(texture.width), height = side_of(texture.height);
    const Taps x = taps_of(u_, width), y = taps_of(v_, height);
    const VI top = hn::Mul(y.first, width), bottom = hn::Mul(y.second, width);
    Texels texels;
    hn::Store(level, di, texels.level);
    hn::Store(hn::Add(top, x.first), di, texels.index[0]);
    hn::Store(hn::Add(top, x.second), di, texels.index[1]);
    hn::Store(hn::Add(bottom, x.first), di, texels.index[2]);
    hn::Store(hn::Add(bottom, x.second), di, texels.index[3]);
    texels.fetch(texture, lanes_);
    const auto mixed = [&](Vec3<D> a, Vec3<D> b, V t) {
      return a * hn::Sub(hn::Set(d, 1), t) + b * t;
    };
    const auto texel = [&](size_t k) { return decoded(texture, texels.rgba[k]); };
    return mixed(mixed(texel(0), texel(1), x.weight), mixed(texel(2), texel(3), x.weight),
                 y.weight);
  }

  // The four of each point.
  struct Texels {
    alignas(64) int32_t level[kLanes];
    alignas(64) int32_t index[4][kLanes];
    alignas(64) uint32_t rgba[4][kLanes];

    HWY_INLINE void fetch(const TextureView& texture, size_t lanes) {
      for (size_t lane = 0; lane < lanes; ++lane) {
        const uint8_t* const of = texture.level[level[lane]];
        for (size_t k = 0; k < 4; ++k)
          memcpy(&rgba[k][lane], of + 4 * static_cast<size_t>(index[k][lane]), 4);
      }
      for (size_t lane = lanes; lane < kLanes; ++lane) {
        for (size_t k = 0; k < 4; ++k) rgba[k][lane] = 0;
      }
    }
  };

  static HWY_INLINE Vec3<D> decoded(const TextureView& texture, const uint32_t* rgba) {
    const D d;
    const DI di;
    const VU bytes = hn::Load(DU(), rgba);
    const auto channel = [&](VU shifted) {
      const VI byte = hn::BitCast(di, hn::And(shifted, hn::Set(DU(), 255)));
      if (texture.srgb_table != nullptr) return hn::GatherIndex(d, texture.srgb_table, byte);
      return hn::Mul(hn::ConvertTo(d, byte), hn::Set(d, 1 / 255.0f));
    };
    return {channel(bytes), channel(hn::ShiftRight<8>(bytes)), channel(hn::ShiftRight<16>(bytes))};
  }

  V u_, v_;  // v from the top
  V images_;
  size_t lanes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
