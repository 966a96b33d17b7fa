// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/triangle/triangle_writer.h"

#include <algorithm>
#include <limits>

namespace tessera::core {
namespace {

constexpr std::uint32_t kNoTriangle = 0xffffffffu;

}  // namespace

template <int W>
LeafRange TriangleWriter<W>::append(std::span<const std::uint32_t> primitives) {
  const std::uint32_t first_block = block_count();
  appended_.insert(appended_.end(), primitives.begin(), primitives.end());
  appended_.resize((appended_.size() + W - 1) / W * W, kNoTriangle);
  return {first_block, block_count() - first_block};
}

template <int W>
void TriangleWriter<W>::fill(std::span<const std::uint32_t> triangles,
                             TriangleBlock<W>* block) const {
  for (; !triangles.empty(); triangles = triangles.subspan(W), ++block) {
    for (std::size_t lane = 0; lane < W; ++lane) {
      const std::uint32_t triangle = triangles[lane];
      const bool is_used = triangle != kNoTriangle;
      for (std::size_t k = 0; k < 9; ++k) {
        block->vertex[k][lane] = is_used ? vertices_[std::size_t{9} * triangle + k]
                                         : std::numeric_limits<float>::quiet_NaN();
      }
      block->primitive[lane] = triangle;
    }
  }
}

template <int W>
std::unique_ptr<LeafWriter> TriangleWriter<W>::fresh() const {
  return std::make_unique<TriangleWriter>(vertices_);
}

template <int W>
std::vector<std::uint32_t> TriangleWriter<W>::make_room(std::span<LeafWriter* const> parts) {
  std::vector<std::uint32_t> bases;
  std::size_t end = blocks_.size();
  for (LeafWriter* const part : parts) {
    bases.push_back(static_cast<std::uint32_t>(end));
    static_cast<TriangleWriter*>(part)->room_ = end;
    end += part->block_count();
  }
  blocks_.reserve(end);
  blocks_.resize(end);
  return bases;
}

template <int W>
void TriangleWriter<W>::move_in(LeafWriter& part) {
  auto& other = static_cast<TriangleWriter&>(part);
  fill(other.appended_, blocks_.data() + other.room_);
  other.appended_ = {};
}

template <int W>
TriangleBlocks<W> TriangleWriter<W>::take() {
  if (blocks_.empty() && !appended_.empty()) {
    blocks_.resize(appended_.size() / W);
    fill(appended_, blocks_.data());
    appended_ = {};
  }
  return std::move(blocks_);
}

template <int W>
std::uint32_t TriangleWriter<W>::block_count() const {
  return static_cast<std::uint32_t>(blocks_.size() + appended_.size() / W);
}

template <int W>
std::span<const std::uint32_t> TriangleWriter<W>::primitives_of(std::uint32_t block) const {
  const std::span<const std::uint32_t> all =
      blocks_.empty() ? std::span(appended_).subspan(std::size_t{block} * W, W)
                      : std::span<const std::uint32_t>(blocks_[block].primitive);
  std::size_t count = 0;
  while (count < all.size() && all[count] != kNoTriangle) ++count;
  return all.first(count);
}

template class TriangleWriter<8>;
template class TriangleWriter<16>;

}  // namespace tessera::core
