// SPDX-License-Identifier: Apache-2.0
// Points where rays meet their triangles, for a whole packet at once, by barycentric-inl.h and
// surface_point-inl.h, whose bounds hold here.
//
// Threads. Works on the caller's memory.
#include "slave/core/surface/surface_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#undef TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_POINTS_INL_H_
#endif

#include "slave/core/primitive/triangle/barycentric-inl.h"
#include "slave/core/surface/surface_point-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Packet: FanPacket or RayPacket.
template <class Packet>
class SurfaceKernel {
  using V = Floats;
  using V3 = Vec3<V>;
  using VI = Ints;

 public:
  SurfaceKernel(const float* vertices, const Packet& rays, const PacketHits& hits)
      : vertices_(vertices), rays_(rays), hits_(hits) {}

  void run(PacketPoints& out) {
    const auto none = set<VI>(static_cast<int32_t>(kNoPrimitive));
    out.met = out.front = out.sliver = 0;
    for (size_t at = 0; at < kPacketRays; at += kLaneCount) {
      const auto primitive = load<VI>(reinterpret_cast<const int32_t*>(hits_.primitive) + at);
      const uint32_t met = bits_of<VI>(primitive != none);
      if (met == 0) continue;
      out.met |= uint64_t{met} << at;
      load_corners(at, static_cast<size_t>(__builtin_ctz(met)));
      for (size_t i = 0; i < kLaneCount; i += kHalf) coordinates(at, i, out);
      place(at, out);
    }
  }

 private:
  using VD3 = Vec3<Doubles>;
  static constexpr size_t kHalf = kLanesOf<Doubles>;

  // Loads the triangles of a register of rays. Rays that have met nothing take that of one that
  // has.
  HWY_INLINE void load_corners(size_t at, size_t some) {
    const uint32_t* const primitive = hits_.primitive + at;
    const auto first = set<VI>(static_cast<int32_t>(primitive[some]));
    const auto own = load<VI>(reinterpret_cast<const int32_t*>(primitive));
    const auto none = set<VI>(static_cast<int32_t>(kNoPrimitive));
    if (is_all<VI>(own == first || own == none)) {
      const float* const p = vertices_ + size_t{9} * primitive[some];
      for (size_t k = 0; k < 9; ++k) store(set<V>(p[k]), corner_[k]);
      return;
    }
    for (size_t lane = 0; lane < kLaneCount; ++lane) {
      const size_t number = primitive[lane] == kNoPrimitive ? primitive[some] : primitive[lane];
      const float* const p = vertices_ + 9 * number;
      for (size_t k = 0; k < 9; ++k) corner_[k][lane] = p[k];
    }
  }

  HWY_INLINE V3 corner(size_t k) const {
    return {load<V>(corner_[3 * k]), load<V>(corner_[3 * k + 1]), load<V>(corner_[3 * k + 2])};
  }

  // The vectors of lanes `at` and on, in double.
  template <size_t kCount>
  static HWY_INLINE VD3 in_double3(const float (&from)[3][kCount], size_t at) {
    return {in_double(from[0] + at), in_double(from[1] + at), in_double(from[2] + at)};
  }
  HWY_INLINE VD3 corner_in_double(size_t k, size_t i) const {
    return {in_double(corner_[3 * k] + i), in_double(corner_[3 * k + 1] + i),
            in_double(corner_[3 * k + 2] + i)};
  }
  static HWY_INLINE VD3 origin_of(const FanPacket& rays, size_t) {
    const auto at = [&](int a) { return set<Doubles>(static_cast<double>(rays.origin[a])); };
    return {at(0), at(1), at(2)};
  }
  static HWY_INLINE VD3 origin_of(const RayPacket& rays, size_t ray) {
    return in_double3(rays.origin, ray);
  }

  HWY_INLINE void coordinates(size_t at, size_t i, PacketPoints& out) const {
    const Barycentric<Doubles> triangle(origin_of(rays_, at + i), corner_in_double(0, i),
                                        corner_in_double(1, i), corner_in_double(2, i));
    const auto met = triangle.of(in_double3(rays_.direction, at + i));
    store(met.u, out.u + at + i);
    store(met.v, out.v + at + i);
  }

  HWY_INLINE void place(size_t at, PacketPoints& out) const {
    const V3 a = corner(0), b = corner(1) - a, c = corner(2) - a;
    const V3 direction = load3<V>(rays_.direction, at);
    const V size = length(direction);
    store(load<V>(hits_.t + at) * size, out.distance + at);
    const V3 across = cross(b, c);
    out.sliver |= uint64_t{bits_of<V>(is_sliver(b, c))} << at;
    const V3 outward = across * (1 / length(across));
    const auto is_front = dot(outward, direction) < 0;
    const V3 normal = negated_if(!is_front, outward);
    const SurfacePoint<V> on =
        surface_point(a, b, c, normal, load<V>(out.u + at), load<V>(out.v + at));
    store3(on.point, out.point, at);
    store3(normal, out.normal, at);
    store(on.offset, out.offset + at);
    out.front |= uint64_t{bits_of<V>(is_front)} << at;
  }

  const float* vertices_;
  const Packet& rays_;
  const PacketHits& hits_;
  alignas(64) float corner_[9][kLaneCount];  // of the register that is being worked on: A, B, C
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
