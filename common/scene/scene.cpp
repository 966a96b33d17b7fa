// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene.h"

namespace tessera {

std::array<const TextureRef*, 14> textures_of(const Material& m) {
  return {&m.albedo_texture,
          &m.emission_texture,
          &m.roughness_metalness_texture,
          &m.normal_texture,
          &m.specular_texture,
          &m.specular_color_texture,
          &m.clearcoat.weight_texture,
          &m.clearcoat.roughness_texture,
          &m.clearcoat.normal_texture,
          &m.sheen.color_texture,
          &m.sheen.roughness_texture,
          &m.transmission.weight_texture,
          &m.anisotropy.texture,
          &m.alpha.texture};
}

std::uint64_t Scene::triangle_count() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances)
    if (instance.kind == ObjectKind::kMesh) count += meshes[instance.mesh]->triangles.size();
  return count;
}

std::uint64_t Scene::patch_count() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances)
    if (instance.kind == ObjectKind::kPatchSurface)
      count += surfaces[instance.mesh]->patches.size();
  return count;
}

}  // namespace tessera
