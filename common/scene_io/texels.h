// SPDX-License-Identifier: Apache-2.0
// Makes pictures from pictures, for readers of formats whose maps mean something else than the
// scene's (heights, exponents, single channels).
//
// Values are shares from 0 to 1 as they are stored, never linearised; a new picture has as many
// bits as the one it is made from, wraps as that one, and is not sRGB. Row 0 is the top.
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "common/scene/scene.h"

namespace tessera {

// Requires: 0 <= x < width_px, 0 <= y < height_px, channel 0 to 3.
float texel_at(const Texture& texture, int x, int y, int channel);
// Luminance of red, green and blue (Rec. 709).
float luminance_at(const Texture& texture, int x, int y);

// Whether red, green and blue are the same everywhere; whether any alpha is below 1.
bool is_grey(const Texture& texture);
bool has_alpha(const Texture& texture);
// Whether the colours are directions that stand out of a surface, as in a normal map: nearly all
// are of about unit length, and they point outward.
bool is_normal_map(const Texture& texture);

// Makes a picture of that size and asks for every value once; values are clamped to [0, 1].
std::shared_ptr<Texture> make_texture(const Texture& like, int width_px, int height_px,
                                      const std::function<float(int x, int y, int channel)>& value);

// Makes a normal map (x along rising u, y along rising v) of a height map. White stands out by
// kBumpHeight * `bump` of the longer side of the picture, whose texels are taken for squares: a
// wall whose picture is a metre wide has joints that are a centimetre deep. Slopes are differences
// over two texels, smoothed across the third direction (I. Sobel, G. Feldman, 1968); beyond the
// edges they go on as the picture wraps.
inline constexpr float kBumpHeight = 0.01f;
std::shared_ptr<Texture> normals_of_heights(const Texture& heights, float bump);

}  // namespace tessera
