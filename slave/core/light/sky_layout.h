// SPDX-License-Identifier: Apache-2.0
// The sky as the kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kSkyPoints = 64;  // of a packet

// View of a SkyMap (sky_map.h).
struct SkyView {
  const float* rgb;  // [height][width][3]
  int32_t width, height;
  const double* rows;            // [height + 1], cumulative from 0 to 1
  const double* columns;         // [height][width + 1], likewise
  const uint16_t* row_guide;     // [height]
  const uint16_t* column_guide;  // [height][width]
};

// Inputs and outputs of sky_light() and sky_samples(); kernel_table.h says which are which. Shape
// of all: [kSkyPoints].
struct alignas(64) SkyPoints {
  float direction[3][kSkyPoints];
  float square[2][kSkyPoints];  // in [0, 1)
  float radiance[3][kSkyPoints];
  float pdf[kSkyPoints];    // by solid angle, with which samples take that direction
  float angle[kSkyPoints];  // of a sample: 1 over its pdf; 0: take nothing
  uint64_t wanted;          // bits of points; the others may become anything
};

}  // namespace tessera::core
