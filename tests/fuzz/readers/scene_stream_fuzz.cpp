// SPDX-License-Identifier: Apache-2.0
// Any bytes as the output of an importer, and as the blocks of a scene, are refused, or give a
// valid scene.
#include <cstdint>
#include <cstdlib>

#include "common/scene/scene_stream.h"
#include "common/scene/validate.h"
#include "tests/fuzz/readers/loose_blocks.h"

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
  // The same bytes are decoded once more as loose blocks with right digests.
  decode_blocks(test::scene_of_loose_blocks(bytes));
  return 0;
}
