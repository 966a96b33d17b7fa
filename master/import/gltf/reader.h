// SPDX-License-Identifier: Apache-2.0
// Reads glTF 2.0 files (.gltf, .glb) as scenes. The stages are document -> textures -> materials ->
// primitives -> nodes, each a file of this folder; README.md says what becomes of every key.
//
// Only parts of the file that the drawn scene uses are read. Each kind of content that the picture
// does not show is one warning. Threads. One.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/scene_io/scene_reader.h"
#include "master/import/gltf/textures.h"

namespace tessera::import {

// Returns: one line that names file, object and key.
Result<ReadScene> read_gltf(const std::string& path, PictureDecoder decode);

}  // namespace tessera::import
