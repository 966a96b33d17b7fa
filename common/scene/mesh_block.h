// SPDX-License-Identifier: Apache-2.0
// The block of a mesh: its arrays, of which the positions are the last one, since they change most
// often: behind them comes nothing that would be sent again for sharing a chunk with them. Normals
// that follow from the positions to the bit (vertex_normals.h) are left out, and the reader makes
// them.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace tessera {

std::vector<std::byte> encode_mesh(const Mesh& mesh);

// Returns: null for malformed bytes.
std::shared_ptr<const Mesh> decode_mesh(std::span<const std::byte> bytes);

// The number of triangles, from the counts alone. Returns: 0 where they cannot be read.
std::uint64_t mesh_triangles(std::span<const std::byte> bytes);

// The materials of its triangles, as Mesh::materials. Returns: none where they cannot be read.
std::vector<std::uint32_t> mesh_materials(std::span<const std::byte> bytes);

}  // namespace tessera
