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
#include "master/import/gltf/deformation.h"
#include "master/import/gltf/document.h"
#include "master/import/gltf/materials.h"
#include "master/import/gltf/motion.h"

namespace tessera::import {

class GltfNodes {
 public:
  // Requires: all outlive it.
  GltfNodes(GltfDocument& document, GltfMaterials& materials, GltfMotion& motion, Scene& scene)
      : document_(document), materials_(materials), motion_(motion), scene_(scene) {}

  // Requires: every index is below the number of nodes.
  Status walk(const std::vector<std::uint32_t>& roots);

  std::uint64_t degenerate_count() const { return degenerate_count_; }

 private:
  struct Place {
    std::uint32_t node;
    int depth;
    Transform parent;
    std::uint32_t parent_number;  // in the motion
  };

  Status visit(const Place& place, std::vector<Place>& open);
  Status add_instances(const GltfObject& node, std::uint32_t mesh, const Transform& to_world,
                       std::uint32_t number);
  Status add_instance(const GltfObject& node, std::uint32_t mesh, const Transform& to_world,
                      const Transform& in_node, std::uint32_t number);
  Result<std::vector<Transform>> instances_of(const GltfObject& node);
  Result<const std::vector<std::uint32_t>*> meshes_of(std::uint32_t mesh);
  std::uint32_t reversed(std::uint32_t mesh);

  GltfDocument& document_;
  GltfMaterials& materials_;
  GltfMotion& motion_;
  Scene& scene_;
  std::vector<bool> is_seen_;                                   // [node]
  std::map<std::uint32_t, std::vector<std::uint32_t>> meshes_;  // mesh of the file -> of the scene
  std::map<std::uint32_t, GltfDeformation> deformations_;  // mesh of the scene -> where it has any
  std::map<std::uint32_t, std::uint32_t> reversed_;        // mesh of the scene -> mirrored
  std::uint64_t degenerate_count_ = 0;
};

}  // namespace tessera::import
