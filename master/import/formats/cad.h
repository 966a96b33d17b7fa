// SPDX-License-Identifier: Apache-2.0
// The plug-in that reads STEP and IGES files, tessera_import_cad.so.
// Threads. Any; it is loaded once, when first asked for, and stays.
#pragma once

#include "common/base/status.h"
#include "master/import/cad/plugin.h"

namespace tessera::import {

inline constexpr const char* kCadPluginFile = "tessera_import_cad.so";

// Returns: the reader; kNotFound, saying what to install.
Result<cad::ReadCadFunction> cad_plugin();

}  // namespace tessera::import
