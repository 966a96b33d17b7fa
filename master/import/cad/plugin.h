// SPDX-License-Identifier: Apache-2.0
// The interface between the importer and its plug-in tessera_import_cad.so, which alone links Open
// CASCADE. Both are of one build, which the name of the function says: values of C++ pass.
//
// Nothing throws across it. The plug-in stays loaded, since the scene's deleters are in it.
#pragma once

#include <cstddef>
#include <string>

#include "common/scene_io/scene_reader.h"

namespace tessera::import::cad {

enum class PluginAnswer : int { kRead = 0, kRefused = 1, kNoMemory = 2 };

// Reads the file `path` into `scene`, or puts a line into `error`.
using ReadCadFunction = PluginAnswer (*)(const std::string& path, ReadScene& scene,
                                         std::string& error);
inline constexpr const char* kReadCadName = "tessera_read_cad_1";

}  // namespace tessera::import::cad
