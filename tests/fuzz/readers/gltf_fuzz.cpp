// SPDX-License-Identifier: Apache-2.0
// Any bytes as a glTF file, through the real tessera-import: whatever happens in it, its caller
// gets a valid scene or one line.
#include <cstdlib>

#include "common/scene/validate.h"
#include "master/loader/load_scene.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bool is_binary = size >= 4 && data[0] == 'g';
  const std::string path = tessera::test::fuzz_file(is_binary ? "a.glb" : "a.gltf", data, size);
  const auto loaded =
      tessera::master::load_scene(path, [](const std::string&, double) { return true; });
  if (loaded.is_ok() ? !tessera::validate_scene(loaded->scene).is_ok()
                     : loaded.status().message().empty()) {
    std::abort();
  }
  return 0;
}
