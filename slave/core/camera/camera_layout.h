// SPDX-License-Identifier: Apache-2.0
// Camera rays of a packet of pixels, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Where in a packet's rectangle of pixels its rays lie, in pixels from the upper left one.
struct alignas(64) PacketShape {
  int32_t width_px, height_px;  // their product is kPacketRays
  alignas(64) int32_t column[kPacketRays];
  alignas(64) int32_t row[kPacketRays];
};

// The direction through the image point (x, y) is corner + x per_x + y per_y.
struct CameraView {
  double corner[3], per_x[3], per_y[3];
};

// One sample of each pixel: see sample_sequence.h.
struct PixelSample {
  uint32_t seed;     // frame_seed()
  uint32_t lens[2];  // of the sequence, not yet scrambled
  uint32_t lens_dimension, key_dimension;
  // Whether the sample is in the middle of the pixel instead.
  bool is_centre;
};

// A packet's pixels; rays beyond right and bottom are left out.
struct PacketPixels {
  const PacketShape* shape;
  int32_t x_px, y_px, right_px, bottom_px;
};

}  // namespace tessera::core
