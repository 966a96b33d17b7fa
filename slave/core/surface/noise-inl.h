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
  using V = Floats;
  using VI = Ints;
  using VU = Uints;

 public:
  static void run(NoisePoints& points) {
    for (int i = 0; i < points.count; i += static_cast<int>(kLaneCount)) {
      const V noise = of(load<V>(points.at[0] + i), load<V>(points.at[1] + i),
                         load<V>(points.at[2] + i), load<VU>(points.seed + i));
      store(noise, points.value + i);
    }
  }

 private:
  static HWY_INLINE V fade(V t) {
    const V curve = t * (t * 6 - 15) + 10;
    return t * t * t * curve;
  }
  static HWY_INLINE V mixed(V t, V a, V b) { return a + t * (b - a); }

  // Component along the gradient of a lattice point: one of 12 edge directions, four of them twice.
  static HWY_INLINE V along_gradient(VU hash, V x, V y, V z) {
    const VU h = shift_right<28>(hash);
    const auto below = [&](uint32_t limit) {  // h < limit, a power of two
      return (h & ~(limit - 1)) == 0;
    };
    const auto one_of_two = (h | 2) == 14;  // 12, 14
    const V u = select(below(8), x, y);
    const V v = select(below(4), y, select(one_of_two, x, z));
    const VU sign_u = shift_left<31>(h);
    const VU sign_v = shift_left<31>(shift_right<1>(h));
    return (u ^ bit_cast<V>(sign_u)) + (v ^ bit_cast<V>(sign_v));
  }

  static HWY_INLINE V of(V px, V py, V pz, VU seed) {
    constexpr float kFar = 4194304;
    const auto is_near = abs(px) < kFar && abs(py) < kFar && abs(pz) < kFar;
    const auto kept = [&](V p) { return zero_unless(is_near, p); };
    px = kept(px);
    py = kept(py);
    pz = kept(pz);
    const V fx = floor(px), fy = floor(py), fz = floor(pz);
    const V x = px - fx, y = py - fy, z = pz - fz;
    // There is one mix for each corner: products with odd numbers keep neighbours apart (Teschner
    // et al., "Optimized spatial hashing", 2003), and the mix makes them random.
    const auto lattice = [&](V whole, uint32_t factor) {
      return bit_cast<VU>(convert<VI>(whole)) * factor;
    };
    const VU x0 = lattice(fx, 73856093u) + seed, x1 = x0 + 73856093u;
    const VU y0 = lattice(fy, 19349663u), y1 = y0 + 19349663u;
    const VU z0 = lattice(fz, 83492791u), z1 = z0 + 83492791u;
    const V x_1 = x - 1, y_1 = y - 1, z_1 = z - 1;
    const auto corner = [&](VU hx, VU hy, VU hz, V cx, V cy, V cz) {
      return along_gradient(mix_bits(hx ^ hy ^ hz), cx, cy, cz);
    };
    const V u = fade(x), v = fade(y), w = fade(z);
    const auto slice = [&](VU hz, V cz) {
      const V near = mixed(u, corner(x0, y0, hz, x, y, cz), corner(x1, y0, hz, x_1, y, cz));
      const V away = mixed(u, corner(x0, y1, hz, x, y_1, cz), corner(x1, y1, hz, x_1, y_1, cz));
      return mixed(v, near, away);
    };
    const V sum = mixed(w, slice(z0, z), slice(z1, z_1));
    return kept(min(max(sum, -1), 1));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
