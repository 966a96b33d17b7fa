// SPDX-License-Identifier: Apache-2.0
// Any bytes as the output of an importer, and as the blocks of a scene, are refused, or give a
// valid scene.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "common/scene/scene_stream.h"
#include "common/scene/validate.h"

namespace {

using namespace tessera;

void decode_blocks(EncodedScene scene) {
  SceneDecoder decoder;
  const auto decoded = decoder.decode(scene);
  if (decoded.is_ok() ? !validate_scene(*decoded).is_ok() : decoded.status().message().empty()) {
    std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const auto stream = decode_scene_stream(bytes);
  if (stream.is_ok()) decode_blocks(stream->scene);
  // Digests hide the decoder behind them from mutations, so the same bytes are decoded once more as
  // five blocks with right digests, after four 16-bit lengths.
  EncodedScene scene;
  for (std::size_t i = 0, begin = 8; size >= 8 && i < 5; ++i) {
    const std::size_t length = i < 4 ? data[2 * i] | std::size_t{data[2 * i + 1]} << 8 : size;
    const std::size_t count = std::min(length, size - begin);
    const auto piece = bytes.subspan(begin, count);
    SceneBlock block;
    block.bytes = std::make_shared<const std::vector<std::byte>>(piece.begin(), piece.end());
    block.digest = sha256(piece);
    scene.blocks.push_back(block);
    begin += count;
  }
  decode_blocks(std::move(scene));
  return 0;
}
