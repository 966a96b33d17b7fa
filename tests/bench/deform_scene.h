// SPDX-License-Identifier: Apache-2.0
// Scenes that deform with time, for suites that measure what that costs.
//
// Threads. Plain functions; a scene's may be called by any thread.
#pragma once

#include <functional>
#include <string>

#include "common/scene/camera.h"
#include "common/scene/scene.h"

namespace tessera::bench {

struct Deforming {
  std::string name;
  std::function<Scene(float seconds)> at;
  Camera camera;
  Vec3f light;
};

Deforming waves();
Deforming swell();  // a sea of a million triangles

}  // namespace tessera::bench
