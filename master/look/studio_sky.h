// SPDX-License-Identifier: Apache-2.0
// The light of a photographer's studio, for scenes that bring none: a soft neutral sky with a
// horizon, a large soft box on the key side, a weaker strip behind on the other one, and a floor
// that gives some light back. It is made by formula; no file is read.
//
// Threads. Pure functions.
#pragma once

#include <memory>

#include "common/scene/scene.h"

namespace tessera::master {

// A white surface that faces the key has irradiance pi, to a few per cent, so exposure 0 shows
// white as white, as a photographer meters a studio's light and not what is put there.
// towards_viewer: from what is shown to the camera; the key stands above and 45 degrees to the
// left of the camera, as in a portrait, whichever way the camera looks first.
std::shared_ptr<const EnvironmentMap> make_studio_sky(Vec3f towards_viewer);

// The gradient that the camera sees behind the scene (Background), as light of the display.
inline constexpr Vec3f kStudioLow{0.055f, 0.058f, 0.063f};
inline constexpr Vec3f kStudioHigh{0.30f, 0.31f, 0.33f};

}  // namespace tessera::master
