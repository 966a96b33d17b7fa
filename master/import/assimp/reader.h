// SPDX-License-Identifier: Apache-2.0
// Reads FBX and COLLADA files through Assimp, which reads no other format here. README.md says what
// becomes of each part of a file.
// Threads. Any, one call at a time.
#pragma once

#include <functional>
#include <span>

#include "common/scene_io/file_format.h"
#include "common/scene_io/scene_reader.h"

namespace tessera::import {

// Decodes a picture that the file holds itself.
using PictureDecoder =
    std::function<Result<std::shared_ptr<const Texture>>(std::span<const std::byte>)>;

// format: kFbx or kCollada, as the file's content says. Returns: one line naming the file.
Result<ReadScene> read_by_assimp(const std::string& path, FileFormat format,
                                 const TextureLoader& load_texture, const PictureDecoder& decode);

}  // namespace tessera::import
