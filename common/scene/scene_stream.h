// SPDX-License-Identifier: Apache-2.0
// A scene and its warnings as one stream of bytes, which tessera-import writes and its parent
// reads.
//
// Bytes, little-endian: "TSIM" u32 version; u64 count of warnings, each u64 length + text; u64
// count of blocks, each u64 length, 32 bytes digest, bytes. Every length is checked against what is
// left.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene_codec.h"

namespace tessera {

struct SceneStream {
  EncodedScene scene;
  std::vector<std::string> warnings;
};

std::vector<std::byte> encode_scene_stream(const SceneStream& stream);

// Returns: kDataLoss for anything malformed, or a block whose digest differs.
Result<SceneStream> decode_scene_stream(std::span<const std::byte> bytes);

}  // namespace tessera
