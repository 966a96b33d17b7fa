// SPDX-License-Identifier: Apache-2.0
// Any bytes as a file of rays, binary and as text, are refused with a line, or give as many rays as
// they have room for.
#include <cstdlib>

#include "slave/tools/ray_file.h"
#include "tests/fuzz/readers/fuzz_file.h"

namespace {

constexpr std::size_t kRaysAtOnce = 7;

void read_all(const std::string& path, std::size_t size) {
  auto file = tessera::tools::RayFile::open(path);
  if (!file.is_ok()) {
    if (file.status().message().empty()) std::abort();
    return;
  }
  for (std::size_t count = 0;;) {
    const auto rays = file->read(kRaysAtOnce);
    if (!rays.is_ok()) {
      if (rays.status().message().empty()) std::abort();
      return;
    }
    if (rays->empty()) return;
    count += rays->size();
    if (rays->size() > kRaysAtOnce || count > size) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_all(tessera::test::fuzz_file("a.rays", data, size), size);
  read_all(tessera::test::fuzz_file("a.csv", data, size), size);
  return 0;
}
