// SPDX-License-Identifier: Apache-2.0
// The suffix of a file name, however it is written: ".OBJ" is ".obj".
// Threads. Pure function.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace tessera {

// Returns: the suffix in lower case, with its dot; empty where there is none.
inline std::string suffix_of(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 'a' - 'A') : c;
  });
  return suffix;
}

}  // namespace tessera
