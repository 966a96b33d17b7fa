// SPDX-License-Identifier: Apache-2.0
#include "master/import/assimp/reader.h"
#include "master/import/read_file.h"
#include "master/import/texture_reader.h"

namespace tessera::import {

Result<ReadScene> read_fbx_file(const std::string& path) {
  return read_by_assimp(path, FileFormat::kFbx, textures_beside(path), read_picture);
}

Result<ReadScene> read_collada_file(const std::string& path) {
  return read_by_assimp(path, FileFormat::kCollada, textures_beside(path), read_picture);
}

}  // namespace tessera::import
