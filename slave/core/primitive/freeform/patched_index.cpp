// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/freeform/patched_index.h"

#include <numeric>
#include <utility>

#include "slave/core/primitive/mixed_writer.h"

namespace tessera::core {

template <int W>
Result<PatchedBvh<W>> index_patches(const PatchedParts& parts,
                                    std::shared_ptr<const PatchStore> patches,
                                    const BuildControl& control) {
  std::vector<Bounds3f> boxes(parts.boxes.begin(), parts.boxes.end());
  const auto triangles = static_cast<std::uint32_t>(boxes.size());
  boxes.insert(boxes.end(), parts.part_boxes.begin(), parts.part_boxes.end());
  std::vector<std::uint32_t> items(parts.part_boxes.size());
  std::iota(items.begin(), items.end(), triangles);
  MixedWriter<W> writer(parts.vertices, items);
  Result<Bvh<W>> bvh = build_bvh<W>({boxes, writer, triangles}, control);
  if (!bvh.is_ok()) return bvh.status();
  PatchedBvh<W> index{std::move(*bvh), writer.take_blocks(), writer.take_triangles(),
                      std::move(patches)};
  for (TriangleBlock<W>& block : index.triangles) {
    for (std::uint32_t& primitive : block.primitive) {
      if (primitive < triangles) primitive = parts.numbers[primitive];
    }
  }
  return index;
}

template Result<PatchedBvh<8>> index_patches<8>(const PatchedParts&,
                                                std::shared_ptr<const PatchStore>,
                                                const BuildControl&);
template Result<PatchedBvh<16>> index_patches<16>(const PatchedParts&,
                                                  std::shared_ptr<const PatchStore>,
                                                  const BuildControl&);

}  // namespace tessera::core
