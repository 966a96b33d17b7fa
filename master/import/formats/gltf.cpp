// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/reader.h"
#include "master/import/read_file.h"
#include "master/import/texture_reader.h"

namespace tessera::import {

Result<ReadScene> read_gltf_file(const std::string& path) { return read_gltf(path, read_picture); }

}  // namespace tessera::import
