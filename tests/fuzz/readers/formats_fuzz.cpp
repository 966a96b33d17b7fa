// SPDX-License-Identifier: Apache-2.0
// Any bytes as a COLLADA, FBX or STL file, through the real tessera-import: whatever happens in it,
// its caller gets a valid scene or one line.
#include <cstdlib>

#include "common/scene/validate.h"
#include "master/loader/load_scene.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const char first = size > 0 ? static_cast<char>(data[0]) : ' ';
  const char* const name = first == '<' ? "a.dae" : first == 's' ? "a.stl" : "a.fbx";
  const std::string path = tessera::test::fuzz_file(name, data, size);
  const auto loaded =
      tessera::master::load_scene(path, [](const std::string&, double) { return true; });
  if (loaded.is_ok() ? !tessera::validate_scene(loaded->scene).is_ok()
                     : loaded.status().message().empty()) {
    std::abort();
  }
  return 0;
}
