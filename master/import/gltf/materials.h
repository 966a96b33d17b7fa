// SPDX-License-Identifier: Apache-2.0
// Materials of a glTF file as materials of the scene (glTF 2.0, section 3.9, and its extensions:
// see lobes.h), each read when a surface first has it.
//
// Occlusion textures are passed over: light computes what they bake. Transparent and smooth solids
// become BsdfKind::kGlass where that draws the same; all others are one glossy surface with lobes.
// Threads. One.
#pragma once

#include <array>
#include <map>
#include <optional>

#include "common/scene/scene.h"
#include "master/import/gltf/document.h"
#include "master/import/gltf/textures.h"

namespace tessera::import {

// What meshes need to know of a material.
struct GltfMaterial {
  std::uint32_t index = 0;  // into Scene::materials
  // Sets of the file's texture coordinates (TEXCOORD_n) that become Mesh::uvs and Mesh::uvs1.
  std::array<std::uint32_t, 2> uv_sets{0, 1};
  bool uses_second_set = false;
  // 0 or 1: the set whose tangents the surface needs, for a normal map or anisotropy.
  std::optional<std::uint32_t> tangent_set;
};

class GltfMaterials {
 public:
  // Requires: all outlive it.
  GltfMaterials(GltfDocument& document, GltfTextures& textures, Scene& scene)
      : document_(document), textures_(textures), scene_(scene) {}

  // The material `index`; none: the format's default material.
  // Requires: index < count("materials").
  const GltfMaterial& read(std::optional<std::uint32_t> index);

 private:
  void read_core(const GltfObject& source, Material& surface);
  void read_alpha(const GltfObject& source, float value, Material& surface);
  void read_emission(const GltfObject& source, Material& surface);
  GltfMaterial place_coordinates(const GltfObject& source, Material& surface);

  GltfDocument& document_;
  GltfTextures& textures_;
  Scene& scene_;
  std::map<std::optional<std::uint32_t>, GltfMaterial> known_;
};

}  // namespace tessera::import
