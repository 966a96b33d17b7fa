// SPDX-License-Identifier: Apache-2.0
// Which meshes and surfaces of patches get a structure of their own that their instances share.
// Threads. Plain values.
#pragma once

#include <cstdint>

namespace tessera::core {

// Which of them share a structure. Answers do not depend on the choice, only time and memory do.
enum class Instancing : std::uint8_t {
  kAuto,   // those of which copies would take some 50 MB (kSharedTrianglesMin, kSharedPatchesMin)
  kNever,  // every instance is flattened
  kAlways  // every one that can be, even those that stand once
};

}  // namespace tessera::core
