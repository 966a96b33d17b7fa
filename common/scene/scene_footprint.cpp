// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

namespace tessera {

std::uint64_t index_bytes_of(const EncodedScene& scene) {
  const PrimitiveCounts counts = primitive_counts_of(scene);
  if (counts.triangles == 0 && counts.patches == 0) return 0;
  return kIndexBytesPerTriangle * counts.triangles + kIndexBytesPerPatch * counts.patches +
         kIndexBytesPerPatchNumber * counts.numbers + kIndexBytesPerTrimPoint * counts.trim_points +
         texture_bytes_of(scene) / 3 * 4;
}

}  // namespace tessera
