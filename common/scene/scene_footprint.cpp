// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

namespace tessera {

std::uint64_t index_bytes_of(const EncodedScene& scene) {
  const std::uint64_t triangles = triangle_count_of(scene);
  return triangles == 0 ? 0 : kIndexBytesPerTriangle * triangles + texture_bytes_of(scene) / 3 * 4;
}

}  // namespace tessera
