// SPDX-License-Identifier: Apache-2.0
#include "master/import/read_file.h"
#include "master/import/texture_reader.h"

namespace tessera::import {

Result<ReadScene> read_obj_file(const std::string& path) {
  return read_obj(path, textures_beside(path));
}

}  // namespace tessera::import
