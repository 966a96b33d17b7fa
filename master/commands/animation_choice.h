// SPDX-License-Identifier: Apache-2.0
// Which animation of a scene is played: what --animation says, else the first one.
// Threads. Any.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera::master {

// Leaves the scene the animation that is played. `asked`: a name, a number from 1, "all" (all of
// them at once), "none" (the rest pose), or empty for the first one.
// Returns: a line for a person about what is played and what else there is, empty for a scene
// without animations; kInvalidArgument that lists them when there is none of that name.
Result<std::string> choose_animation(Scene& scene, const std::string& asked);

}  // namespace tessera::master
