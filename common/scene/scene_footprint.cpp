// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

#include "common/scene/surface_copies.h"

namespace tessera {

std::uint64_t index_bytes_of(const EncodedScene& scene, const SurfaceBytes& surface_bytes) {
  const PrimitiveCounts counts = primitive_counts_of(scene);
  if (counts.triangles == 0 && counts.patches == 0) return 0;
  std::uint64_t bytes = kIndexBytesPerTriangle * counts.triangles + texture_bytes_of(scene) / 3 * 4;
  if (counts.patches > 0) bytes += kIndexBytesOfThreads;
  if (surface_bytes && counts.patches > 0) {
    for (const SurfaceCopies& surface : surface_copies_of(scene))
      bytes += surface_bytes(scene.blocks[surface.block], surface.copies, counts.patches);
  } else {
    bytes += kIndexBytesPerPatch * counts.patches + 2 * sizeof(float) * counts.numbers +
             kIndexBytesPerTrimPoint * counts.trim_points;
  }
  return bytes;
}

}  // namespace tessera
