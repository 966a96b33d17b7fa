// SPDX-License-Identifier: Apache-2.0
// Surfaces that scatter light, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/bsdf/albedo_layout.h"

namespace tessera::core {

inline constexpr int kBsdfPoints = 64;

// Shape of all: [kBsdfPoints].
struct alignas(64) BsdfPoints {
  // Inputs.
  float normal[3][kBsdfPoints];  // shading normal, unit
  float square[2][kBsdfPoints];  // for sampling: random points in [0, 1)
  // Inputs of BSDFs that scatter in lobes; see Surface.
  float to_viewer[3][kBsdfPoints];
  float albedo[3][kBsdfPoints], specular[3][kBsdfPoints];
  float roughness[kBsdfPoints], metalness[kBsdfPoints];

  // Direction to the light, unit: an input of evaluation, an output of sampling.
  float direction[3][kBsdfPoints];
  // Output: of evaluation, the BSDF times pi; of sampling, BSDF times cosine over pdf.
  float value[3][kBsdfPoints];
  float pdf[kBsdfPoints];  // output: of the direction, by solid angle

  int32_t count;
};

}  // namespace tessera::core
