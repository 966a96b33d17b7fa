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

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class DiscontinuityFilter {
  using D = hn::CappedTag<float, 16>;
  using DI = hn::CappedTag<int32_t, 16>;
  using V = hn::Vec<D>;

 public:
  DiscontinuityFilter(FilterPlanes& planes, int radius) : planes_(planes), radius_(radius) {}

  // The pixels of `width` x `height` from (x, y) on.
  void run(int x, int y, int width, int height) {
    const int lanes = static_cast<int>(hn::Lanes(D()));
    for (int row = y; row < y + height; ++row) {
      for (int column = 0; column < width; column += lanes) filter(filter_index(x + column, row));
    }
  }

 private:
  static HWY_INLINE V dot3(const V (&a)[3], const V (&b)[3]) {
    return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
  }
  static HWY_INLINE void load(const float (&from)[3][kFilterPixels], int at, V (&to)[3]) {
    for (int c = 0; c < 3; ++c) to[c] = hn::LoadU(D(), from[c] + at);
  }

  // Lanes from `at` on that may take what those from `from` on have.
  HWY_INLINE hn::Mask<D> is_like(const V (&point)[3], const V (&normal)[3], V distance, int at,
                                 int from) const {
    const D d;
    const DI di;
    V other_point[3], other_normal[3], chord[3];
    load(planes_.point, from, other_point);
    load(planes_.normal, from, other_normal);
    for (int c = 0; c < 3; ++c) chord[c] = hn::Sub(other_point[c], point[c]);
    const V rise = dot3(normal, chord);
    const V other = hn::LoadU(d, planes_.distance + from);
    const auto is_flat = hn::Le(hn::Mul(hn::Mul(rise, rise), hn::Set(d, 16)), dot3(chord, chord));
    const auto is_turned_alike = hn::Ge(dot3(normal, other_normal), hn::Set(d, 0.9f));
    const auto is_near =
        hn::Le(hn::Mul(hn::Abs(hn::Sub(other, distance)), hn::Set(d, 8)), hn::Min(other, distance));
    const auto is_same = hn::RebindMask(
        d, hn::Eq(hn::LoadU(di, planes_.material + at), hn::LoadU(di, planes_.material + from)));
    return hn::And(hn::And(is_flat, is_turned_alike), hn::And(is_near, is_same));
  }

  HWY_INLINE void filter(int at) {
    const D d;
    V point[3], normal[3], sum[3];
    load(planes_.point, at, point);
    load(planes_.normal, at, normal);
    const V distance = hn::LoadU(d, planes_.distance + at);
    V count = hn::Zero(d);
    for (V& s : sum) s = hn::Zero(d);
    for (int dy = -radius_; dy <= radius_; ++dy) {
      for (int dx = -radius_; dx <= radius_; ++dx) {
        const int from = at + dy * kFilterStride + dx;
        const auto mask = is_like(point, normal, distance, at, from);
        count = hn::Add(count, hn::IfThenElseZero(mask, hn::Set(d, 1)));
        for (int c = 0; c < 3; ++c) {
          const V light = hn::LoadU(d, planes_.light[c] + from);
          sum[c] = hn::Add(sum[c], hn::IfThenElseZero(mask, light));
        }
      }
    }
    const V scale = hn::Div(hn::Set(d, 1), hn::Max(count, hn::Set(d, 1)));
    const auto is_there = hn::Gt(count, hn::Zero(d));
    for (int c = 0; c < 3; ++c) {
      const V albedo = hn::LoadU(d, planes_.albedo[c] + at);
      const V reflected = hn::IfThenElseZero(is_there, hn::Mul(albedo, hn::Mul(sum[c], scale)));
      hn::StoreU(hn::Add(hn::LoadU(d, planes_.sum[c] + at), reflected), d, planes_.sum[c] + at);
    }
  }

  FilterPlanes& planes_;
  const int radius_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
