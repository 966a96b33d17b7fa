// SPDX-License-Identifier: Apache-2.0
// The bytes of a material in the root block of a scene (README.md).
// Threads. One at a time.
#pragma once

#include <cstdint>

#include "common/scene/block_bytes.h"
#include "common/scene/scene.h"

namespace tessera {

void put_material(BlockWriter& out, const Material& material);

// Returns: false for bytes that are missing or name a kind that does not exist.
bool get_material(BlockReader& in, Material& material);

// Bytes of a material without a name, the fewest that a material takes.
std::uint64_t material_bytes_min();

}  // namespace tessera
