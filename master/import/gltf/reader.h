// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 files (.gltf, .glb) as scenes: the stages document -> textures -> materials -> primitives
// -> nodes, each a file of this folder; README.md says what becomes of every key.
//
// Only what the drawn scene uses is read. What the file has and the picture has not is one warning
// for each kind. Threads. One.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/scene_io/scene_reader.h"
#include "master/import/gltf/textures.h"

namespace tessera::import {

// Returns: one line that names file, object and key.
Result<ReadScene> read_gltf(const std::string& path, PictureDecoder decode);

}  // namespace tessera::import
