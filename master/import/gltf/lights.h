// SPDX-License-Identifier: Apache-2.0
// Lamps of a glTF file (KHR_lights_punctual) and its cameras, placed by their nodes.
//
// The extension's units are photometric, the scene's are watts. A lumen is 1/683 W, the definition
// at 555 nm, as Blender's importer has it by default; no spectrum is known that would tell more:
//   point, spot   candela (lm/sr) / 683 = W/sr
//   directional   lux (lm/m2) / 683     = W/m2 on a surface that faces it
// `range` is a hint for renderers that cut light off at a distance; no light is cut off here.
//
// Threads. One.
#pragma once

#include "common/math/transform.h"
#include "common/scene/scene.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

inline constexpr float kLumensPerWatt = 683;

// Adds the lamp that `node` holds, if there is one, placed by `to_world`. A lamp or camera with
// values that none can have is left out, with a warning.
void add_light(const GltfDocument& document, const GltfObject& node, const Transform& to_world,
               Scene& scene);
// All perspective cameras become Scene::cameras, the first of them Scene::camera. They are named
// after their node, else by their own name, else by their number.
void add_camera(const GltfDocument& document, const GltfObject& node, const Transform& to_world,
                Scene& scene);

}  // namespace tessera::import
