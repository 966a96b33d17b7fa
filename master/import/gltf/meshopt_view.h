// SPDX-License-Identifier: Apache-2.0
// Unpacks buffer views of EXT_meshopt_compression by the library of the extension's author
// (Kapoulkine, "meshoptimizer"), which is confined to the .cpp file.
// Threads. Pure function.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "common/base/status.h"
#include "master/import/gltf/object.h"

namespace tessera::import {

// `packed`: the extension's object; `bytes`: the packed bytes that it names.
// Returns: count * byteStride bytes, or an error that names the view and the key.
Result<std::string> unpack_meshopt_view(const GltfObject& packed, std::span<const std::byte> bytes);

}  // namespace tessera::import
