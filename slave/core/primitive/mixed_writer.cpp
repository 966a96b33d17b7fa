// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/mixed_writer.h"

#include <algorithm>

#include "slave/core/primitive/shapes_layout.h"

namespace tessera::core {

// Primitives ascend, so triangles come first.
template <int W>
LeafRange MixedWriter<W>::append(std::span<const std::uint32_t> primitives) {
  const std::uint32_t first = block_count();
  const auto triangle_count = static_cast<std::uint32_t>(vertices_.size() / 9);
  const auto end = std::lower_bound(primitives.begin(), primitives.end(), triangle_count);
  const auto triangles = static_cast<std::size_t>(end - primitives.begin());
  if (triangles > 0) {
    const LeafRange range = triangles_.append(primitives.first(triangles));
    for (std::uint32_t i = 0; i < range.count; ++i) blocks_.push_back(range.first + i);
  }
  for (const std::uint32_t primitive : primitives.subspan(triangles))
    blocks_.push_back((primitive - triangle_count) | kIsItem);
  return {first, block_count() - first};
}

template <int W>
std::unique_ptr<LeafWriter> MixedWriter<W>::fresh() const {
  return std::make_unique<MixedWriter>(vertices_, items_);
}

template <int W>
std::vector<std::uint32_t> MixedWriter<W>::make_room(std::span<LeafWriter* const> parts) {
  std::vector<LeafWriter*> triangle_parts;
  for (LeafWriter* const part : parts)
    triangle_parts.push_back(&static_cast<MixedWriter*>(part)->triangles_);
  const std::vector<std::uint32_t> triangle_bases = triangles_.make_room(triangle_parts);
  std::vector<std::uint32_t> bases;
  std::size_t end = blocks_.size();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto& part = static_cast<MixedWriter&>(*parts[i]);
    bases.push_back(static_cast<std::uint32_t>(end));
    part.room_ = end;
    part.triangle_room_ = triangle_bases[i];
    end += part.blocks_.size();
  }
  blocks_.reserve(end);
  blocks_.resize(end);
  return bases;
}

template <int W>
void MixedWriter<W>::move_in(LeafWriter& part) {
  auto& other = static_cast<MixedWriter&>(part);
  triangles_.move_in(other.triangles_);
  std::transform(other.blocks_.begin(), other.blocks_.end(), blocks_.data() + other.room_,
                 [&other](std::uint32_t block) {
                   return (block & kIsItem) != 0 ? block : block + other.triangle_room_;
                 });
}

template <int W>
void MixedWriter<W>::reserve(std::size_t block_count) {
  blocks_.reserve(block_count);
}

template <int W>
std::span<const std::uint32_t> MixedWriter<W>::primitives_of(std::uint32_t block) const {
  const std::uint32_t at = blocks_[block];
  if ((at & kIsItem) == 0) return triangles_.primitives_of(at);
  return items_.subspan(at ^ kIsItem, 1);
}

template class MixedWriter<8>;
template class MixedWriter<16>;

}  // namespace tessera::core
