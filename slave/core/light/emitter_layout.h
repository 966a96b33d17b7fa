// SPDX-License-Identifier: Apache-2.0
// Light that triangles shed on surfaces, as the kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kLitPoints = 64;

// Surfaces that are lit; see Surface. Shape of all: [kLitPoints].
struct alignas(64) LitSurfaces {
  float point[3][kLitPoints];
  float normal[3][kLitPoints];
  float shading_normal[3][kLitPoints];
  float offset[kLitPoints];
};

// One sample of an emitter for each surface. Shape of all: [kLitPoints].
struct alignas(64) EmitterSamples {
  // Inputs: the emitter, see light_set.h, and the sample.
  float a[3][kLitPoints], edge_b[3][kLitPoints], edge_c[3][kLitPoints];
  float emitter_normal[3][kLitPoints];
  float area[kLitPoints];
  float chance[kLitPoints];     // with which this emitter was picked
  float square[2][kLitPoints];  // in [0, 1)

  // Outputs.
  float u[kLitPoints], v[kLitPoints];  // place on the emitter
  float to_light[3][kLitPoints];       // unit
  float strength[kLitPoints];      // share of the radiance that the surface gets, over pi; 0: none
  float pdf[kLitPoints];           // by solid angle, of this sample
  float start[3][kLitPoints];      // of the shadow ray
  float direction[3][kLitPoints];  // of the shadow ray, which ends just before the emitter at t = 1

  int32_t count;
  float samples;  // for each surface
};

}  // namespace tessera::core
