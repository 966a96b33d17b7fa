// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/placed/surface_index.h"

#include <numeric>
#include <utility>

#include "slave/core/primitive/mixed_writer.h"

namespace tessera::core {

template <int W>
SurfaceShape<W> SurfaceIndex<W>::shape() const {
  return {structure.nodes.data(),
          blocks.data(),
          surface->parts.data(),
          surface->patches.data(),
          static_cast<std::uint32_t>(surface->parts.size()),
          scene_box(structure.bounds)};
}

template <int W>
Result<std::shared_ptr<const SurfaceIndex<W>>> index_surface(
    std::shared_ptr<const SharedSurface> surface, const BuildControl& control) {
  std::vector<std::uint32_t> items(surface->parts.size());
  std::iota(items.begin(), items.end(), 0u);
  MixedWriter<W> writer({}, items);
  Result<Bvh<W>> bvh = build_bvh<W>({surface->boxes, writer, 0}, control);
  if (!bvh.is_ok()) return bvh.status();
  auto index = std::make_shared<SurfaceIndex<W>>();
  index->structure = std::move(*bvh);
  index->blocks = writer.take_blocks();
  index->blocks.shrink_to_fit();
  index->surface = std::move(surface);
  return std::shared_ptr<const SurfaceIndex<W>>(std::move(index));
}

template struct SurfaceIndex<8>;
template struct SurfaceIndex<16>;
template Result<std::shared_ptr<const SurfaceIndex<8>>> index_surface<8>(
    std::shared_ptr<const SharedSurface>, const BuildControl&);
template Result<std::shared_ptr<const SurfaceIndex<16>>> index_surface<16>(
    std::shared_ptr<const SharedSurface>, const BuildControl&);

}  // namespace tessera::core
