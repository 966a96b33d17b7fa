// SPDX-License-Identifier: Apache-2.0
// Parses what stands behind a key of an MTL file that takes a picture: options, and the picture's
// name (Alias, "The .mtl file format", 1992, "Options for texture map statements").
//
// Threads. Pure function.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/scene_io/scene_pictures.h"

namespace tessera {

// -s, -o, -bm, -mm, -clamp, -blendu with -blendv and -imfchan are drawn; other options are named in
// PictureUse::not_drawn. `text` is what follows the key. Returns: an empty name where there is
// none.
PictureUse parse_mtl_texture(const std::string& key, std::uint64_t line, std::string_view text);

}  // namespace tessera
