// glTF 2 (.gltf, .glb) through Assimp: meshes, node transforms as instances in node order, base
// colours and their textures, metallic-roughness with its texture, emission, transmission and index
// of refraction, cameras, punctual lights. In the limited process only;
// Assimp is confined to gltf_reader.cpp.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/scene_io/scene_reader.h"

namespace tessera::import {

Result<ReadScene> read_gltf(const std::string& path);

}  // namespace tessera::import
