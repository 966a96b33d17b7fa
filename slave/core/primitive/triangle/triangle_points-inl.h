// SPDX-License-Identifier: Apache-2.0
// Where rays meet their triangles: all of a packet at once, with the operations of barycentric() and
// surface_point() (slave/core/geometry), to the bit, so that the bounds derived there hold here.
//
// Threads. Works on the caller's memory.
#include "slave/core/surface/surface_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#undef TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#endif

#include "slave/core/surface/surface_point-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Packet: FanPacket or RayPacket.
template <class Packet>
class SurfaceKernel {
  using D = hn::CappedTag<float, 16>;
  using DI = hn::RebindToSigned<D>;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;
  static constexpr size_t kLanes = hn::MaxLanes(D());

 public:
  SurfaceKernel(const float* vertices, const Packet& rays, const PacketHits& hits)
      : vertices_(vertices), rays_(rays), hits_(hits) {}

  void run(PacketPoints& out) {
    const DI di;
    const auto none = hn::Set(di, static_cast<int32_t>(kNoPrimitive));
    out.met = out.front = out.sliver = 0;
    for (size_t at = 0; at < kPacketRays; at += kLanes) {
      const auto primitive = hn::Load(di, reinterpret_cast<const int32_t*>(hits_.primitive) + at);
      const uint32_t met = bits_of(di, hn::Ne(primitive, none));
      if (met == 0) continue;
      out.met |= uint64_t{met} << at;
      load_corners(at, static_cast<size_t>(__builtin_ctz(met)));
      for (size_t i = 0; i < kLanes; i += kHalf) barycentric(at, i, out);
      place(at, out);
    }
  }

 private:
  using Double = hn::CappedTag<double, kLanes>;
  using VD = hn::Vec<Double>;
  static constexpr size_t kHalf = hn::MaxLanes(Double());

  using VD3 = Vec3<Double>;

  static constexpr float kSliver = 0x1p-16f;  // surface_offset.h

  // Rays that have met nothing take the triangle of one that has.
  HWY_INLINE void load_corners(size_t at, size_t some) {
    const D d;
    const DI di;
    const uint32_t* const primitive = hits_.primitive + at;
    const auto first = hn::Set(di, static_cast<int32_t>(primitive[some]));
    const auto own = hn::Load(di, reinterpret_cast<const int32_t*>(primitive));
    const auto none = hn::Set(di, static_cast<int32_t>(kNoPrimitive));
    if (hn::AllTrue(di, hn::Or(hn::Eq(own, first), hn::Eq(own, none)))) {
      const float* const p = vertices_ + size_t{9} * primitive[some];
      for (size_t k = 0; k < 9; ++k) hn::Store(hn::Set(d, p[k]), d, corner_[k]);
      return;
    }
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const size_t number = primitive[lane] == kNoPrimitive ? primitive[some] : primitive[lane];
      const float* const p = vertices_ + 9 * number;
      for (size_t k = 0; k < 9; ++k) corner_[k][lane] = p[k];
    }
  }

  HWY_INLINE V3 corner(size_t k) const {
    const D d;
    return {hn::Load(d, corner_[3 * k]), hn::Load(d, corner_[3 * k + 1]),
            hn::Load(d, corner_[3 * k + 2])};
  }

  static HWY_INLINE VD widened(const float* from) {
    const Double d;
    return hn::PromoteTo(d, hn::Load(hn::Rebind<float, Double>(), from));
  }
  HWY_INLINE VD3 corner_in_double(size_t k, size_t i) const {
    return {widened(corner_[3 * k] + i), widened(corner_[3 * k + 1] + i),
            widened(corner_[3 * k + 2] + i)};
  }
  static HWY_INLINE VD3 origin_of(const FanPacket& rays, size_t) {
    const Double d;
    const auto at = [&](int a) { return hn::Set(d, static_cast<double>(rays.origin[a])); };
    return {at(0), at(1), at(2)};
  }
  static HWY_INLINE VD3 origin_of(const RayPacket& rays, size_t ray) {
    return {widened(rays.origin[0] + ray), widened(rays.origin[1] + ray),
            widened(rays.origin[2] + ray)};
  }

  HWY_INLINE void barycentric(size_t at, size_t i, PacketPoints& out) const {
    const Double d;
    const hn::Rebind<float, Double> df;
    const VD3 a = corner_in_double(0, i);
    const VD3 b = corner_in_double(1, i) - a, c = corner_in_double(2, i) - a;
    const VD3 from = origin_of(rays_, at + i) - a;
    const VD3 direction{widened(rays_.direction[0] + at + i), widened(rays_.direction[1] + at + i),
                        widened(rays_.direction[2] + at + i)};
    const VD3 p = cross(direction, c);
    const auto volume = dot(b, p);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1);
    const auto is_there = hn::Ne(volume, zero);
    const auto share = [&](VD value) {
      const auto within = hn::Min(hn::Max(hn::Div(value, volume), zero), one);
      return hn::DemoteTo(df, hn::IfThenElseZero(is_there, hn::Add(within, zero)));
    };
    const auto u = share(dot(from, p)), v = share(dot(direction, cross(from, b)));
    hn::Store(u, df, out.u + at + i);
    hn::Store(hn::Min(v, hn::Sub(hn::Set(df, 1), u)), df, out.v + at + i);
  }

  HWY_INLINE void place(size_t at, PacketPoints& out) const {
    const D d;
    const V3 a = corner(0), b = corner(1) - a, c = corner(2) - a;
    const V3 direction = load3(d, rays_.direction, at);
    const V size = length(direction);
    hn::Store(hn::Mul(hn::Load(d, hits_.t + at), size), d, out.distance + at);
    const V3 across = cross(b, c);
    const V thin = hn::Mul(hn::Set(d, kSliver), hn::Mul(dot(b, b), dot(c, c)));
    out.sliver |= uint64_t{bits_of(d, hn::Not(hn::Ge(dot(across, across), thin)))} << at;
    const V3 outward = across * hn::Div(hn::Set(d, 1), length(across));
    const auto is_front = hn::Lt(dot(outward, direction), hn::Zero(d));
    const V3 normal = negated_if(hn::Not(is_front), outward);
    const OffsetPoint<D> on =
        surface_point(d, a, b, c, normal, hn::Load(d, out.u + at), hn::Load(d, out.v + at));
    store3(d, on.point, out.point, at);
    store3(d, normal, out.normal, at);
    hn::Store(on.offset, d, out.offset + at);
    out.front |= uint64_t{bits_of(d, is_front)} << at;
  }

  const float* vertices_;
  const Packet& rays_;
  const PacketHits& hits_;
  alignas(64) float corner_[9][kLanes];  // of the register at hand: A, B, C
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
