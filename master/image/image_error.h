// SPDX-License-Identifier: Apache-2.0
// How far a picture is from a reference, in figures.
//
// Threads. Pure functions.
#pragma once

#include <span>

namespace tessera::master {

struct ImageError {
  double rmse = 0;      // of linear radiance, over pixels and channels
  double rel_mse = 0;   // mean of (a - b)^2 / (b^2 + 0.01 m^2), m: the reference's mean radiance
  double flip = 0;      // mean of flip_map(): what a person sees, 0 to 1
  double mean_off = 0;  // (mean of the picture) / (mean of the reference) - 1
};

// Shapes: [3 * width * height], linear RGB, row by row. Requires: both of that size, not empty.
ImageError image_error(std::span<const float> image, std::span<const float> reference, int width_px,
                       int height_px);

}  // namespace tessera::master
