// SPDX-License-Identifier: Apache-2.0
// Writes the corpus of scene_stream_fuzz, so that it has the layout of today.
// Usage: make_scene_corpus FOLDER
#include <cstdio>
#include <fstream>

#include "common/scene/scene_stream.h"
#include "tests/fuzz/readers/loose_blocks.h"
#include "tests/support/surface_scene.h"

namespace {

bool write(const std::string& path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file.good();
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tessera;
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_scene_corpus FOLDER\n");
    return 2;
  }
  const std::string folder = std::string(argv[1]) + "/";
  const EncodedScene small = SceneEncoder().encode(test::make_small_scene());
  const EncodedScene surfaces = SceneEncoder().encode(test::make_surface_scene());
  // A corpus that is refused would find nothing.
  SceneDecoder decoder;
  const auto decoded = decoder.decode(test::scene_of_loose_blocks(test::loose_blocks(surfaces)));
  if (!decoded.is_ok()) {
    std::fprintf(stderr, "make_scene_corpus: %s\n", decoded.status().message().c_str());
    return 1;
  }
  const bool is_written = write(folder + "small.stream", encode_scene_stream({small, {"one"}})) &&
                          write(folder + "surfaces.stream", encode_scene_stream({surfaces, {}})) &&
                          write(folder + "surfaces.blocks", test::loose_blocks(surfaces));
  if (!is_written) std::fprintf(stderr, "make_scene_corpus: cannot write to %s\n", argv[1]);
  return is_written ? 0 : 1;
}
