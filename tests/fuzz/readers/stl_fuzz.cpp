// SPDX-License-Identifier: Apache-2.0
// Any bytes as an STL file are refused with a line, or give a valid scene.
#include <cstdlib>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = tessera::read_stl(tessera::test::fuzz_file("a.stl", data, size));
  if (read.is_ok() ? !tessera::validate_scene(read->scene).is_ok()
                   : read.status().message().empty()) {
    std::abort();
  }
  return 0;
}
