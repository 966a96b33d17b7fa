// SPDX-License-Identifier: Apache-2.0
// Reads a scene file, or a sky, by the reader that its row of common/scene_io/file_formats.inc
// names. Each reader is a file in master/import/formats.
//
// Threads. Functions of one thread. Errors: one line naming the file.
#pragma once

#include <string>

#include "common/scene_io/file_format.h"
#include "common/scene_io/scene_reader.h"

namespace tessera::import {

#define TESSERA_FORMAT(enumerator, suffix, name, kind, place, begins, look, reader) \
  Result<ReadScene> reader(const std::string& path);
#include "common/scene_io/file_formats.inc"

// Reads a file of any format: the one that its suffix says and its content agrees with.
Result<ReadScene> read_file(const std::string& path);

}  // namespace tessera::import
