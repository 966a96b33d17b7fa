// SPDX-License-Identifier: Apache-2.0
// Sub-patches that emit. A sample is uniform over the sub-patch's square, so its pdf by area is one
// over |dS/du x dS/dv| times the square's own area: it varies, and each sample carries its own.
//
// Threads. Pure functions.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/light/emitter.h"
#include "slave/core/primitive/freeform/patch_store.h"

namespace tessera::core {

// A point of an emitter that is sampled as if the whole emitter were as it is there.
struct PatchEmitterPoint {
  Vec3f point;
  Vec3f normal;    // unit, of the side that emits
  float area = 0;  // one over the pdf by area; 0 where nothing is there
  float u = 0, v = 0;
};

// Requires: the emitter is a sub-patch of the store.
PatchEmitterPoint sample_on_patch(const PatchStore& patches, const Emitter& emitter, Vec2f square);
// The same for a point that was found otherwise; u, v: the patch's own, on the sub-patch.
PatchEmitterPoint point_on_patch(const PatchStore& patches, const Emitter& emitter, float u,
                                 float v);

// Where emitters go, with what their texture numbers count.
struct EmitterList {
  std::vector<Emitter>& emitters;
  std::vector<EmitterTexture>& textures;
};

// Appends the emitters of an instance of patches, by rising number. maps: of the scene's textures,
// by index. Returns: whether all that emits has emitters; what is opaque in parts only has none.
bool add_patch_emitters(const Scene& scene, std::size_t instance, const PatchStore& patches,
                        std::span<const std::shared_ptr<const MipMap>> maps, EmitterList to);

}  // namespace tessera::core
