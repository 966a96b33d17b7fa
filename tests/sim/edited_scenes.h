// SPDX-License-Identifier: Apache-2.0
// Scenes that differ by edits, and that are built and met by rays: a cloth whose corners move and
// whose triangles come and go, then objects that move, change, appear and vanish. What rays meet
// goes into the picture, so that a structure which does not fit its scene shows, and so does one
// that somebody has freed.
//
// Threads. The simulation's one.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::sim {

// The scene with this tag: that of the tag before it and one drawn edit. Requires: 0 <= tag <
// kSceneTagsMax.
Scene edited_scene(int tag);

// A number that stands for what a bundle of rays meets. It depends on the scene alone, not on how
// it came to be built.
std::uint64_t met_by_rays(const core::PreparedScene& scene);

}  // namespace tessera::sim
