// SPDX-License-Identifier: Apache-2.0
// Hands the bytes of a fuzz input to readers that take a path.
// Threads. One at a time; the folder is the process's own and goes with it.
#pragma once

#include <cstdint>
#include <string>

#include "tests/support/temp_folder.h"

namespace tessera::test {

// Returns: a file `name` with these bytes, in a folder of its own; the next call writes it anew.
inline std::string fuzz_file(const std::string& name, const std::uint8_t* data, std::size_t size) {
  static const TempFolder folder;
  return folder.write(name, std::string(reinterpret_cast<const char*>(data), size));
}

}  // namespace tessera::test
