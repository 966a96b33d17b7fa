// SPDX-License-Identifier: Apache-2.0
// Any bytes as a file of patches are refused with a line, or give a valid scene.
#include <cstdlib>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = tessera::read_bpt(tessera::test::fuzz_file("a.bpt", data, size));
  if (!read.is_ok()) {
    const std::string& line = read.status().message();
    if (line.empty() || line.find('\n') != std::string::npos) std::abort();
    return 0;
  }
  // Numbers have no limit in the format but that of float32.
  const auto status = tessera::validate_scene(read->scene);
  if (!status.is_ok() && status.message().find("too large") == std::string::npos) std::abort();
  return 0;
}
