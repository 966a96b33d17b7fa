#include "common/scene/scene_footprint.h"

namespace tessera {

std::uint64_t index_bytes_of(const EncodedScene& scene) {
  return kIndexBytesPerTriangle * triangle_count_of(scene);
}

}  // namespace tessera
