// SPDX-License-Identifier: Apache-2.0
// One primitive of a glTF mesh as a mesh of the scene: triangles, strips and fans, with indices or
// without, packed or not (glTF 2.0, section 3.7.2).
//
// Accessors that cannot be read, positions that are not finite and indices out of range are
// refused; other invalid values are repaired, with a warning. A mesh without normals is flat.
// Threads. One.
#pragma once

#include <memory>

#include "common/scene/scene.h"
#include "master/import/gltf/deformation.h"
#include "master/import/gltf/document.h"
#include "master/import/gltf/materials.h"

namespace tessera::import {

struct GltfPrimitive {
  std::shared_ptr<Mesh> mesh;
  GltfDeformation deformation;
};

// Returns: no mesh, with a warning, for a primitive that holds no triangles (points, lines); an
// error that names mesh and primitive for one that is refused.
Result<GltfPrimitive> read_primitive(GltfDocument& document, const GltfObject& primitive,
                                     GltfMaterials& materials);

}  // namespace tessera::import
