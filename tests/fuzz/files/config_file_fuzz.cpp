// SPDX-License-Identifier: Apache-2.0
// Any bytes as a configuration file (TOML) are refused with a line that names the file, or give
// words for known options alone.
#include <algorithm>
#include <cstdlib>

#include "master/commands/options.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::string> kKnown{"listen", "keys", "samples", "verbose", "fov"};
  const std::string path = tessera::test::fuzz_file("a.toml", data, size);
  const auto words = tessera::master::read_config_file(path, kKnown, {"keys"});
  if (!words.is_ok()) {
    if (words.status().message().find("a.toml") == std::string::npos) std::abort();
    return 0;
  }
  for (const std::string& word : *words) {
    const auto is_of = [&](const std::string& name) {
      return word == "--" + name || word.starts_with("--" + name + "=");
    };
    if (is_of("keys") || std::none_of(kKnown.begin(), kKnown.end(), is_of)) std::abort();
  }
  return 0;
}
