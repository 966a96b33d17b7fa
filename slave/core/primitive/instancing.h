// SPDX-License-Identifier: Apache-2.0
// Which meshes of a scene get a structure of their own that their instances share.
// Threads. Plain values.
#pragma once

#include <cstdint>

namespace tessera::core {

// Which meshes share a structure. Answers do not depend on the choice, only time and memory do.
enum class Instancing : std::uint8_t {
  kAuto,   // meshes of which copies would take more than some 50 MB (kSharedTrianglesMin)
  kNever,  // every instance is flattened
  kAlways  // every mesh that can be, even those that stand once
};

}  // namespace tessera::core
