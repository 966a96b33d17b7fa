// SPDX-License-Identifier: Apache-2.0
// Names that a scene file gives to other files: only regular files below the scene's own folder are
// opened, also when links lead elsewhere.
// Threads. Pure but for the file system.
#pragma once

#include <string>

#include "common/base/status.h"

namespace tessera {

// Returns: the real path of `name` below `folder` (empty: the current one); else
// kPermissionDenied or kNotFound, worded to follow the name.
Result<std::string> confined_path(const std::string& folder, const std::string& name);

}  // namespace tessera
