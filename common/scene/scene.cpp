#include "common/scene/scene.h"

namespace tessera {

std::uint64_t Scene::triangle_count() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances) count += meshes[instance.mesh]->triangles.size();
  return count;
}

}  // namespace tessera
