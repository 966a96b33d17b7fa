// SPDX-License-Identifier: Apache-2.0
// Decodes pictures that a scene file names to RGBA by tessera_image's plug-in, in the limited
// process only. A texture has 8 bits a channel where the file has at most 8, otherwise 16.
//
// Only regular files below the scene's folder are read: no absolute names, no "..", no links out of
// it, no devices. Threads. One.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "common/scene_io/scene_reader.h"

namespace tessera::import {

// `folder`: the folder of the scene file. Returns: why the picture is refused, which becomes a
// warning.
Result<std::shared_ptr<const Texture>> read_texture_file(const std::string& folder,
                                                         const std::string& name);
// Loader for pictures that are named relative to the scene file at `path`.
TextureLoader textures_beside(const std::string& path);
// Decodes a PNG, JPEG or WebP picture, which is known by its first bytes. Colours are not
// multiplied by alpha.
Result<std::shared_ptr<const Texture>> read_picture(std::span<const std::byte> bytes);

// Reads a latitude-longitude picture of any format that the plug-in reads, usually .hdr or .exr;
// negative values become zero. `path` is not confined to a folder. Returns: why the picture cannot
// be read.
Result<std::shared_ptr<const EnvironmentMap>> read_environment_file(const std::string& path);

}  // namespace tessera::import
