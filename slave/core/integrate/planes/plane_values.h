// SPDX-License-Identifier: Apache-2.0
// What one camera ray gives to each plane of a picture (common/frame/picture_plane.h says what they
// are). Threads. Pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "common/frame/picture_plane.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

// A camera ray and the first surface that it meets; what is seen in mirrors and through glass does
// not count.
struct CameraSample {
  const Surface* surface = nullptr;  // null: nothing is met; object and material are then 0
  Vec3f eye, view;                   // of the camera; view: unit viewing direction
  std::uint32_t object = 0;          // number of the instance, from 1
  std::uint32_t material = 0;        // of the scene, from 1
};

// Shape: to [channel_count of the plane's row].
using PlaneValue = void (*)(const CameraSample& sample, float* to);

// Requires: the plane's number is below plane_count().
PlaneValue plane_value(Plane plane);

// Values of the planes of more_plane_rows(), in their order; a test links its own in place of these
// (more_plane_values.cpp).
std::span<const PlaneValue> more_plane_values();

}  // namespace tessera::core
