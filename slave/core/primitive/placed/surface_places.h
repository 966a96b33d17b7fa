// SPDX-License-Identifier: Apache-2.0
// Which surfaces of patches are split once for all of their places, and which places they are:
// where copies would take much memory, and the bits of the flattened scene are sure.
//
// Threads. Plain functions.
#pragma once

#include <vector>

#include "common/scene/scene.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/instancing.h"

namespace tessera::core {

// Returns: by surface, whether places share it where their maps allow it. Surfaces with trims, and
// those that shed light, whose sub-patches are lamps each, are not among them.
std::vector<bool> shareable_surfaces(const Scene& scene, Instancing instancing);

// is_shareable: shareable_surfaces(). known: what another version of the scene shares, which is
// taken where it is the same; or null. Places are flattened whose maps have no inverse in float32
// or leave its range, and those that may leave a patch without extent there, whose parts would have
// no numbers. Numbers of primitives are not set. Returns: empty lists where no place shares.
SharedPlaces place_surfaces(const Scene& scene, const std::vector<bool>& is_shareable,
                            const PatchSplitting& splitting, const SharedPlaces* known);

}  // namespace tessera::core
