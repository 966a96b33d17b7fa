// SPDX-License-Identifier: Apache-2.0
// Camera rays of a packet and the keys of its pixels, as CameraRays::direction(), pixel_key() and
// SequencePoint have them, to the bit: in double, rounded once.
//
// Threads. Works on the caller's memory.
#include "slave/core/camera/camera_layout.h"

#if defined(TESSERA_CORE_CAMERA_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CAMERA_INL_H_
#undef TESSERA_CORE_CAMERA_INL_H_
#else
#define TESSERA_CORE_CAMERA_INL_H_
#endif

#include "slave/core/sampling/sequence-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class CameraKernel {
  using D = hn::CappedTag<float, 16>;
  using DI = hn::RebindToSigned<D>;
  using DU = hn::RebindToUnsigned<D>;
  static constexpr size_t kLanes = hn::MaxLanes(D());

 public:
  CameraKernel(const CameraView& camera, const PixelSample& sample)
      : camera_(camera), sample_(sample) {}

  void run(const PacketPixels& pixels, FanPacket& rays, uint32_t* keys) {
    const DI di;
    const DU du;
    rays.active = 0;
    for (size_t at = 0; at < kPacketRays; at += kLanes) {
      const auto x = hn::Add(hn::Set(di, pixels.x_px), hn::Load(di, pixels.shape->column + at));
      const auto y = hn::Add(hn::Set(di, pixels.y_px), hn::Load(di, pixels.shape->row + at));
      const auto is_there = hn::And(hn::Lt(x, hn::Set(di, pixels.right_px)),
                                    hn::Lt(y, hn::Set(di, pixels.bottom_px)));
      rays.active |= uint64_t{bits_of(di, is_there)} << at;
      auto key = hash_combine(du, hn::Set(du, sample_.seed), hn::BitCast(du, x));
      key = hash_combine(du, key, hn::BitCast(du, y));
      hn::Store(hash_combine(du, key, hn::Set(du, sample_.key_dimension)), du, keys + at);
      hn::Store(x, di, x_);
      hn::Store(y, di, y_);
      place(hash_combine(du, key, hn::Set(du, sample_.lens_dimension)));
      for (size_t i = 0; i < kLanes; i += kHalf) directions(i, rays, at + i);
    }
  }

 private:
  using Double = hn::CappedTag<double, kLanes>;
  static constexpr size_t kHalf = hn::MaxLanes(Double());

  // Where in its pixel each sample lies.
  HWY_INLINE void place(hn::Vec<DU> key) {
    const D d;
    const DU du;
    if (sample_.is_centre) {
      hn::Store(hn::Set(d, 0.5f), d, in_x_);
      hn::Store(hn::Set(d, 0.5f), d, in_y_);
    } else {
      hn::Store(unit_float(du, hn::Xor(hn::Set(du, sample_.lens[0]), key)), d, in_x_);
      const auto y = hn::Xor(hn::Set(du, sample_.lens[1]), mix_bits(du, key));
      hn::Store(unit_float(du, y), d, in_y_);
    }
  }

  HWY_INLINE void directions(size_t i, FanPacket& rays, size_t to) const {
    const Double d;
    const hn::Rebind<float, Double> df;
    const hn::Rebind<int32_t, Double> di;
    const auto x =
        hn::Add(hn::PromoteTo(d, hn::Load(df, in_x_ + i)), hn::PromoteTo(d, hn::Load(di, x_ + i)));
    const auto y =
        hn::Add(hn::PromoteTo(d, hn::Load(df, in_y_ + i)), hn::PromoteTo(d, hn::Load(di, y_ + i)));
    for (int a = 0; a < 3; ++a) {
      const auto along_x =
          hn::Add(hn::Set(d, camera_.corner[a]), hn::Mul(x, hn::Set(d, camera_.per_x[a])));
      const auto sum = hn::Add(along_x, hn::Mul(y, hn::Set(d, camera_.per_y[a])));
      hn::Store(hn::DemoteTo(df, sum), df, rays.direction[a] + to);
    }
  }

  const CameraView& camera_;
  const PixelSample& sample_;
  alignas(64) int32_t x_[kLanes], y_[kLanes];
  alignas(64) float in_x_[kLanes], in_y_[kLanes];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
