// SPDX-License-Identifier: Apache-2.0
// Pictures that a scene file names, decoded to RGBA by tessera_image's plug-in, in the limited process only: of 8
// bits a channel where the file has so many or fewer, of 16 where it has more.
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

// `folder`: the scene file's. Returns: why the picture is refused, to become a warning.
Result<std::shared_ptr<const Texture>> read_texture_file(const std::string& folder,
                                                         const std::string& name);
// The same of files beside a scene file of that path.
TextureLoader textures_beside(const std::string& path);
// A PNG, JPEG or WebP picture, known by its first bytes; alpha does not touch its colours.
Result<std::shared_ptr<const Texture>> read_picture(std::span<const std::byte> bytes);

// A latitude-longitude picture of any format, .hdr and .exr first of all; what is below zero there
// becomes zero. Not confined to a folder. Returns: why it cannot be read.
Result<std::shared_ptr<const EnvironmentMap>> read_environment_file(const std::string& path);

}  // namespace tessera::import
