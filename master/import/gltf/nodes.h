// SPDX-License-Identifier: Apache-2.0
// Walks the nodes of one scene of a glTF file, root by root and each node before its children, and
// adds instances of meshes in that order, lamps and cameras (glTF 2.0, section 3.5).
//
// A node that is its own ancestor, or has two parents, is refused; so is a chain of nodes that is
// longer than any real model has. Threads. One.
#pragma once

#include <map>
#include <vector>

#include "common/math/transform.h"
#include "common/scene/scene.h"
#include "master/import/gltf/document.h"
#include "master/import/gltf/materials.h"

namespace tessera::import {

class GltfNodes {
 public:
  // Requires: all outlive it.
  GltfNodes(GltfDocument& document, GltfMaterials& materials, Scene& scene)
      : document_(document), materials_(materials), scene_(scene) {}

  // Requires: every index is below the number of nodes.
  Status walk(const std::vector<std::uint32_t>& roots);

  bool has_morph_targets() const { return has_morph_targets_; }
  std::uint64_t degenerate_count() const { return degenerate_count_; }

 private:
  struct Place {
    std::uint32_t node;
    int depth;
    Transform parent;
  };

  Status visit(const Place& place, std::vector<Place>& open);
  Status add_instances(const GltfObject& node, std::uint32_t mesh, const Transform& to_world);
  Result<std::vector<Transform>> instances_of(const GltfObject& node);
  Result<const std::vector<std::uint32_t>*> meshes_of(std::uint32_t mesh);
  std::uint32_t reversed(std::uint32_t mesh);

  GltfDocument& document_;
  GltfMaterials& materials_;
  Scene& scene_;
  std::vector<bool> is_seen_;                                   // [node]
  std::map<std::uint32_t, std::vector<std::uint32_t>> meshes_;  // mesh of the file -> of the scene
  std::map<std::uint32_t, std::uint32_t> reversed_;             // mesh of the scene -> mirrored
  bool has_morph_targets_ = false;
  std::uint64_t degenerate_count_ = 0;
};

}  // namespace tessera::import
