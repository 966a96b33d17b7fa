// SPDX-License-Identifier: Apache-2.0
// What a picture's file says of itself, and how a picture is compared with a file that says how it
// is shown. Threads. Pure functions.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/frame_settings.h"
#include "master/image/image_read.h"

namespace tessera::master {

// Returns: "Software", and texts whose names begin with "tessera:": scene, camera, settings (as
// options that give this picture again), seed, samples (per pixel, of all passes), passes,
// render_seconds, exposure, tone.
std::vector<std::pair<std::string, std::string>> picture_attributes(const std::string& scene,
                                                                    const FrameSettings& settings,
                                                                    int passes,
                                                                    double render_seconds);

// Linear pixels as `reference` shows its own. If it is made for a display (8 bits), they go through
// the exposure and tone curve that its attributes name; otherwise they stay as they are.
std::vector<float> seen_like(const FloatImage& reference, std::span<const float> rgb);

}  // namespace tessera::master
