// SPDX-License-Identifier: Apache-2.0
// What stands behind a key of an MTL file that takes a picture: options, and the picture's name
// (Alias, "The .mtl file format", 1992, "Options for texture map statements").
//
// Threads. Pure function.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/scene_io/scene_pictures.h"

namespace tessera {

// -s, -o, -bm, -mm, -clamp, -blendu with -blendv and -imfchan are drawn, others are named in the
// answer. `text`: what follows the key. The answer's name is empty where there is none.
PictureUse parse_mtl_texture(const std::string& key, std::uint64_t line, std::string_view text);

}  // namespace tessera
