// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_fitter.h"

#include <algorithm>
#include <limits>

namespace tessera::core {
namespace {

constexpr std::uint32_t kNoTriangle = 0xffffffffu;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// The corners of one triangle. A corner is read as four floats, of which the last is the next
// corner's, so the last triangle of all is copied to where there is room for that.
class Corners {
 public:
  const float* of(std::span<const float> vertices, std::uint32_t triangle) {
    if (triangle == kNoTriangle) {
      std::fill_n(copy_, 10, kNaN);
      return copy_;
    }
    const float* const corners = vertices.data() + std::size_t{9} * triangle;
    if (std::size_t{9} * triangle + 10 <= vertices.size()) return corners;
    std::copy_n(corners, 9, copy_);
    copy_[9] = 0;
    return copy_;
  }

 private:
  float copy_[10];
};

// Brings the corners of four triangles side by side into lanes of the block. The box grows by them;
// NaN leaves it as it is.
template <int W>
void fit_four(std::span<const float> vertices, int lane, TriangleBlock<W>& block, Box4& box) {
  Corners copies[4];
  const float* corners[4];
  for (int i = 0; i < 4; ++i) corners[i] = copies[i].of(vertices, block.primitive[lane + i]);
  for (int c = 0; c < 9; c += 3) {
    __m128 row[4];
    for (int i = 0; i < 4; ++i) {
      row[i] = _mm_loadu_ps(corners[i] + c);
      box.grow({row[i]}, {row[i]});
    }
    _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
    for (int a = 0; a < 3; ++a) _mm_store_ps(block.vertex[c + a] + lane, row[a]);
  }
}

}  // namespace

template <int W>
Box4 TriangleFitter<W>::fit(const LeafRange& leaf) const {
  Box4 box;
  for (std::uint32_t b = leaf.first; b < leaf.first + leaf.count; ++b) {
    for (int lane = 0; lane < W; lane += 4) fit_four(vertices_, lane, blocks_[b], box);
  }
  return box;
}

template class TriangleFitter<8>;
template class TriangleFitter<16>;

}  // namespace tessera::core
