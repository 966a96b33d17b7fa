// SPDX-License-Identifier: Apache-2.0
// Gradient noise (see slave/core/surface/noise.h), a point to a lane.
//
// Threads. Works on the caller's memory.
#include "slave/core/surface/noise_layout.h"

#if defined(TESSERA_CORE_NOISE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_NOISE_INL_H_
#undef TESSERA_CORE_NOISE_INL_H_
#else
#define TESSERA_CORE_NOISE_INL_H_
#endif

#include "slave/core/sampling/sequence-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class NoiseLanes {
  using D = hn::CappedTag<float, 16>;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;
  using VU = hn::Vec<DU>;

 public:
  static void run(NoisePoints& points) {
    const D d;
    const DU du;
    for (int i = 0; i < points.count; i += static_cast<int>(hn::Lanes(d))) {
      const V noise = of(hn::Load(d, points.at[0] + i), hn::Load(d, points.at[1] + i),
                         hn::Load(d, points.at[2] + i), hn::Load(du, points.seed + i));
      hn::Store(noise, d, points.value + i);
    }
  }

 private:
  static HWY_INLINE V fade(V t) {
    const D d;
    const V curve =
        hn::Add(hn::Mul(t, hn::Sub(hn::Mul(t, hn::Set(d, 6)), hn::Set(d, 15))), hn::Set(d, 10));
    return hn::Mul(hn::Mul(hn::Mul(t, t), t), curve);
  }
  static HWY_INLINE V mixed(V t, V a, V b) { return hn::Add(a, hn::Mul(t, hn::Sub(b, a))); }

  // Component along the gradient of a lattice point: one of 12 edge directions, four of them twice.
  static HWY_INLINE V along_gradient(VU hash, V x, V y, V z) {
    const D d;
    const DU du;
    const VU h = hn::ShiftRight<28>(hash);
    const auto is = [&](auto mask) { return hn::RebindMask(d, mask); };
    const auto below = [&](uint32_t limit) {  // h < limit, a power of two
      return is(hn::Eq(hn::AndNot(hn::Set(du, limit - 1), h), hn::Zero(du)));
    };
    const auto one_of_two = is(hn::Eq(hn::Or(h, hn::Set(du, 2)), hn::Set(du, 14)));  // 12, 14
    const V u = hn::IfThenElse(below(8), x, y);
    const V v = hn::IfThenElse(below(4), y, hn::IfThenElse(one_of_two, x, z));
    const VU sign_u = hn::ShiftLeft<31>(h);
    const VU sign_v = hn::ShiftLeft<31>(hn::ShiftRight<1>(h));
    return hn::Add(hn::Xor(u, hn::BitCast(d, sign_u)), hn::Xor(v, hn::BitCast(d, sign_v)));
  }

  static HWY_INLINE V of(V px, V py, V pz, VU seed) {
    const D d;
    const DU du;
    const hn::RebindToSigned<D> di;
    const V far = hn::Set(d, 4194304), one = hn::Set(d, 1);
    const auto is_near = hn::And(hn::Lt(hn::Abs(px), far),
                                 hn::And(hn::Lt(hn::Abs(py), far), hn::Lt(hn::Abs(pz), far)));
    const auto kept = [&](V p) { return hn::IfThenElseZero(is_near, p); };
    px = kept(px);
    py = kept(py);
    pz = kept(pz);
    const V fx = hn::Floor(px), fy = hn::Floor(py), fz = hn::Floor(pz);
    const V x = hn::Sub(px, fx), y = hn::Sub(py, fy), z = hn::Sub(pz, fz);
    // One mix a corner: products with odd numbers keep neighbours apart (Teschner et al., "Optimized
    // spatial hashing", 2003), the mix makes chance of it.
    const auto lattice = [&](V floor, uint32_t factor) {
      return hn::Mul(hn::BitCast(du, hn::ConvertTo(di, floor)), hn::Set(du, factor));
    };
    const VU x0 = hn::Add(lattice(fx, 73856093u), seed), x1 = hn::Add(x0, hn::Set(du, 73856093u));
    const VU y0 = lattice(fy, 19349663u), y1 = hn::Add(y0, hn::Set(du, 19349663u));
    const VU z0 = lattice(fz, 83492791u), z1 = hn::Add(z0, hn::Set(du, 83492791u));
    const V x_1 = hn::Sub(x, one), y_1 = hn::Sub(y, one), z_1 = hn::Sub(z, one);
    const auto corner = [&](VU hx, VU hy, VU hz, V cx, V cy, V cz) {
      return along_gradient(mix_bits(du, hn::Xor(hn::Xor(hx, hy), hz)), cx, cy, cz);
    };
    const V u = fade(x), v = fade(y), w = fade(z);
    const auto slice = [&](VU hz, V cz) {
      const V near = mixed(u, corner(x0, y0, hz, x, y, cz), corner(x1, y0, hz, x_1, y, cz));
      const V away = mixed(u, corner(x0, y1, hz, x, y_1, cz), corner(x1, y1, hz, x_1, y_1, cz));
      return mixed(v, near, away);
    };
    const V sum = mixed(w, slice(z0, z), slice(z1, z_1));
    return kept(hn::Min(hn::Max(sum, hn::Neg(one)), one));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
