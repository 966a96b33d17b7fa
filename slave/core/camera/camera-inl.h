// SPDX-License-Identifier: Apache-2.0
// Directions of camera rays, computed in double and rounded once, and the kernel that makes those
// of a packet of pixels. The pixels' keys and the points in them are those of pixel_key() and
// SequencePoint.
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

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// Component of the direction through the image point (x, y). T: double, or a register of doubles.
template <class T>
TESSERA_INLINE FloatOf<T> camera_direction(const CameraView& camera, int axis, T x, T y) {
  return convert<FloatOf<T>>(camera.corner[axis] + x * camera.per_x[axis] + y * camera.per_y[axis]);
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#ifndef TESSERA_PLAIN_TEXT

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class CameraKernel {
 public:
  CameraKernel(const CameraView& camera, const PixelSample& sample)
      : camera_(camera), sample_(sample) {}

  void run(const PacketPixels& pixels, FanPacket& rays, uint32_t* keys) {
    rays.active = 0;
    for (size_t at = 0; at < kPacketRays; at += kLaneCount) {
      const Ints x = pixels.x_px + load<Ints>(pixels.shape->column + at);
      const Ints y = pixels.y_px + load<Ints>(pixels.shape->row + at);
      const auto is_there = x < pixels.right_px && y < pixels.bottom_px;
      rays.active |= uint64_t{bits_of<Ints>(is_there)} << at;
      Uints key = hash_combine(set<Uints>(sample_.seed), bit_cast<Uints>(x));
      key = hash_combine(key, bit_cast<Uints>(y));
      store(hash_combine(key, set<Uints>(sample_.key_dimension)), keys + at);
      store(x, x_);
      store(y, y_);
      place(hash_combine(key, set<Uints>(sample_.lens_dimension)));
      for (size_t i = 0; i < kLaneCount; i += kLanesOf<Doubles>) directions(i, rays, at + i);
    }
  }

 private:
  // Finds where in its pixel each sample lies.
  HWY_INLINE void place(Uints key) {
    if (sample_.is_centre) {
      store(set<Floats>(0.5f), in_x_);
      store(set<Floats>(0.5f), in_y_);
    } else {
      const auto point =
          scrambled_point(set<Uints>(sample_.lens[0]), set<Uints>(sample_.lens[1]), key);
      store(point.x, in_x_);
      store(point.y, in_y_);
    }
  }

  HWY_INLINE void directions(size_t i, FanPacket& rays, size_t to) const {
    const Doubles x = in_double(in_x_ + i) + in_double(x_ + i);
    const Doubles y = in_double(in_y_ + i) + in_double(y_ + i);
    for (int a = 0; a < 3; ++a) store(camera_direction(camera_, a, x, y), rays.direction[a] + to);
  }

  const CameraView& camera_;
  const PixelSample& sample_;
  alignas(64) int32_t x_[kLaneCount], y_[kLaneCount];
  alignas(64) float in_x_[kLaneCount], in_y_[kLaneCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
