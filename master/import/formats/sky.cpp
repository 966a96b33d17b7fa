// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "master/import/read_file.h"
#include "master/import/texture_reader.h"

namespace tessera::import {

// Reads a picture as a scene that holds nothing but a sky.
Result<ReadScene> read_sky_file(const std::string& path) {
  auto map = read_environment_file(path);
  if (!map.is_ok()) return map.status();
  ReadScene read;
  read.scene.materials.emplace_back();
  read.scene.environment = {1, 1, 1};
  read.scene.environment_map = std::move(*map);
  return read;
}

}  // namespace tessera::import
