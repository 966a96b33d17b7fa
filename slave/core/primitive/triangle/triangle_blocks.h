// Triangles side by side in blocks of W, as the kernels test them.
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "slave/core/accel/bvh_layout.h"

namespace tessera::core {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

// Appends as many blocks as `count` triangles need, W to each. number_of(i): the i-th of them.
// Shape: vertices [triangle_count][3][3].
template <int W, typename NumberOf>
void append_blocks(std::span<const float> vertices, std::uint32_t count, const NumberOf& number_of,
                   std::vector<TriangleBlock<W>>& blocks) {
  for (std::uint32_t first = 0; first < count; first += W) {
    TriangleBlock<W>& block = blocks.emplace_back();
    for (std::uint32_t lane = 0; lane < W; ++lane) {
      const bool is_used = first + lane < count;
      const std::uint32_t primitive = is_used ? number_of(first + lane) : kNoTriangle;
      for (std::size_t k = 0; k < 9; ++k) {
        block.vertex[k][lane] = is_used ? vertices[std::size_t{9} * primitive + k]
                                        : std::numeric_limits<float>::quiet_NaN();
      }
      block.primitive[lane] = primitive;
    }
  }
}

}  // namespace tessera::core
