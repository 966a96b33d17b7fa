// SPDX-License-Identifier: Apache-2.0
// The discontinuity buffer (Benthin, thesis, section 9.1; Keller, "Interleaved sampling", 2001):
// a pixel takes the mean of what its neighbours that show the same surface have gathered, each from
// VPLs of its own. No distance is absolute: a neighbour is accepted where its normal is within some
// 25 degrees, its point within 15 degrees of the plane, its distance from the eye within an eighth
// and its material the same. With radius 0 a pixel keeps what it has.
//
// Threads. Works on the caller's memory.
#include "slave/core/light/gather_layout.h"

#if defined(TESSERA_CORE_IRRADIANCE_FILTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_IRRADIANCE_FILTER_INL_H_
#undef TESSERA_CORE_IRRADIANCE_FILTER_INL_H_
#else
#define TESSERA_CORE_IRRADIANCE_FILTER_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class DiscontinuityFilter {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  DiscontinuityFilter(FilterPlanes& planes, int radius) : planes_(planes), radius_(radius) {}

  // Filters `width` x `height` pixels from (x, y) on.
  void run(int x, int y, int width, int height) {
    const int lanes = static_cast<int>(kLaneCount);
    for (int row = y; row < y + height; ++row) {
      for (int column = 0; column < width; column += lanes) filter(filter_index(x + column, row));
    }
  }

 private:
  static HWY_INLINE V3 vectors(const float (&from)[3][kFilterPixels], int at) {
    return {load_unaligned<V>(from[0] + at), load_unaligned<V>(from[1] + at),
            load_unaligned<V>(from[2] + at)};
  }

  // Returns: the lanes from `at` on that may take the light of those from `from` on.
  HWY_INLINE MaskOf<V> is_like(V3 point, V3 normal, V distance, int at, int from) const {
    const V3 chord = vectors(planes_.point, from) - point;
    const V rise = dot(normal, chord);
    const V other = load_unaligned<V>(planes_.distance + from);
    const auto is_flat = rise * rise * 16 <= dot(chord, chord);
    const auto is_turned_alike = dot(normal, vectors(planes_.normal, from)) >= 0.9f;
    const auto is_near = abs(other - distance) * 8 <= min(other, distance);
    const auto is_same = load_unaligned<Ints>(planes_.material + at) ==
                         load_unaligned<Ints>(planes_.material + from);
    return is_flat && is_turned_alike && is_near && mask_as<V>(is_same);
  }

  HWY_INLINE void filter(int at) {
    const V3 point = vectors(planes_.point, at), normal = vectors(planes_.normal, at);
    const V distance = load_unaligned<V>(planes_.distance + at);
    V count = set<V>(0);
    V3 sum;
    for (int dy = -radius_; dy <= radius_; ++dy) {
      for (int dx = -radius_; dx <= radius_; ++dx) {
        const int from = at + dy * kFilterStride + dx;
        const auto mask = is_like(point, normal, distance, at, from);
        count += zero_unless(mask, set<V>(1));
        sum = sum + zero_unless(mask, vectors(planes_.light, from));
      }
    }
    const V scale = 1 / max(count, 1);
    const V3 reflected = zero_unless(count > 0, vectors(planes_.albedo, at) * (sum * scale));
    const V3 all = vectors(planes_.sum, at) + reflected;
    store_unaligned(all.x, planes_.sum[0] + at);
    store_unaligned(all.y, planes_.sum[1] + at);
    store_unaligned(all.z, planes_.sum[2] + at);
  }

  FilterPlanes& planes_;
  const int radius_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
