// SPDX-License-Identifier: Apache-2.0
// Sub-patches that emit. A sample is uniform over the sub-patch's square, so its pdf by area is one
// over |dS/du x dS/dv| times the square's own area: it varies, and each sample carries its own.
//
// Threads. Pure functions.
#pragma once

#include <memory>
#include <span>

#include "common/scene/scene.h"
#include "slave/core/light/light_set.h"

namespace tessera::core {

// A point of an emitter that is sampled as if the whole emitter were as it is there.
struct PatchEmitterPoint {
  Vec3f point;
  Vec3f normal;    // unit, of the side that emits
  float area = 0;  // one over the pdf by area; 0 where the surface is a line
  float u = 0, v = 0;
};

// Requires: the emitter is a sub-patch of the store.
PatchEmitterPoint sample_on_patch(const PatchStore& patches, const Emitter& emitter, Vec2f square);
// The same for a point that was found otherwise; u, v: the patch's own, on the sub-patch.
PatchEmitterPoint point_on_patch(const PatchStore& patches, const Emitter& emitter, float u,
                                 float v);

// Appends the emitters of an instance of patches, by rising number. textures: as make_light_set()
// has them.
void add_patch_emitters(const Scene& scene, std::size_t instance,
                        std::span<const std::shared_ptr<const MipMap>> textures, LightSet& set);

}  // namespace tessera::core
