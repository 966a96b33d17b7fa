// SPDX-License-Identifier: Apache-2.0
// Which extensions of glTF 2.0 are read, and what is said of the others.
// Threads. Pure functions.
#pragma once

#include "common/base/status.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

// Adds one warning for each extension that the file uses and that is not read. Returns: an error
// for an extension that the file requires and that is not known.
Status check_extensions(GltfDocument& document);

}  // namespace tessera::import
