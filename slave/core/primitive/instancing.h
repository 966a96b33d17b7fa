// SPDX-License-Identifier: Apache-2.0
// Which meshes of a scene get a structure of their own that their instances share.
// Threads. Plain values.
#pragma once

#include <cstdint>

namespace tessera::core {

// Which meshes share a structure. Answers do not depend on the choice, only time and memory do.
enum class Instancing : std::uint8_t {
  kAuto,   // meshes of which copies would take more than some 50 MB
  kNever,  // every instance is flattened
  kAlways  // every mesh that can be, even those that stand once
};

// kAuto: a mesh is shared where copies of it would have at least this many triangles, about 100
// bytes each. Tracing instances costs time, so memory has to be worth it.
inline constexpr std::uint64_t kSharedTrianglesMin = std::uint64_t{1} << 19;

}  // namespace tessera::core
