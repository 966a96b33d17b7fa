// SPDX-License-Identifier: Apache-2.0
// Unpacks triangles and vertices of KHR_draco_mesh_compression by Google's library, which is
// confined to the .cpp file.
// Threads. One.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "master/import/gltf/accessor.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

struct DracoMesh {
  std::vector<std::uint32_t> indices;
  // Accessors by the name of the attribute ("POSITION"); they point into `values`.
  std::map<std::string, GltfAccessor> attributes;
  std::vector<std::unique_ptr<std::vector<float>>> values;
};

// `packed`: the extension's object of a primitive; `attributes`: the primitive's own, whose
// accessors say what is normalised. Returns: an error that names the primitive and the key.
Result<DracoMesh> unpack_draco(GltfDocument& document, const GltfObject& packed,
                               const GltfObject& attributes);

}  // namespace tessera::import
