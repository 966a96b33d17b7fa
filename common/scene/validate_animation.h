// SPDX-License-Identifier: Apache-2.0
// The part of validate_scene() (validate.h) that is about what moves with time.
// Threads. Pure function.
#pragma once

#include "common/base/status.h"
#include "common/scene/animation.h"
#include "common/scene/scene.h"

namespace tessera {

// Checks that the arrays fit each other and the scene, that every node comes behind its parent, and
// every number. Returns: kInvalidArgument or kResourceExhausted naming node, channel, key, joint or
// vertex by number.
Status validate_animation(const SceneAnimation& animation, const Scene& scene);

}  // namespace tessera
