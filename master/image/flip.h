// SPDX-License-Identifier: Apache-2.0
// FLIP says where a person who flips between two pictures sees a difference: Andersson, Nilsson,
// Akenine-Moeller, Oskarsson, Astroem, Fairchild, "FLIP: a difference evaluator for alternating
// images", 2020. This is the variant for displays: radiance above 1 is clamped.
//
// Threads. Pure function.
#pragma once

#include <span>
#include <vector>

namespace tessera::master {

// A display of 0.7 m in width and 3840 pixels, seen from 0.7 m.
inline constexpr double kFlipPixelsPerDegree = 67.02;

// Shapes: [3 * width * height], linear RGB (Rec. 709). Returns: [width * height], 0 (no difference)
// to 1.
std::vector<float> flip_map(std::span<const float> image, std::span<const float> reference,
                            int width_px, int height_px);

}  // namespace tessera::master
