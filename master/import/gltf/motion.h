// SPDX-License-Identifier: Apache-2.0
// What moves in a glTF scene: animations, skins and morph targets (glTF 2.0, sections 3.7.3 and
// 3.11), gathered while the nodes are walked and made into Scene::animation at the end.
//
// Keys, joints and numbers that cannot be are refused with the name of animation, channel or skin.
// Channels of nodes that are not drawn, and of properties that are not played, are left out, the
// latter with a warning. Threads. One.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/scene/animation.h"
#include "common/scene/scene.h"
#include "master/import/gltf/deformation.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

// A node's place at rest, without its parent; a rotation of length 0 counts as none.
MotionNode read_place(const GltfObject& node);

class GltfMotion {
 public:
  // Requires: both outlive it.
  GltfMotion(GltfDocument& document, Scene& scene) : document_(document), scene_(scene) {}

  // A node, after its parent's number (kNoIndex: a root). Returns: its number.
  std::uint32_t enter(std::uint32_t node, MotionNode rest, std::uint32_t parent);

  // What the node carries: the last instance, light, camera of the scene.
  void carry_instance(std::uint32_t number, const Transform& in_node);
  void carry_light(std::uint32_t number);
  void carry_camera(std::uint32_t number);

  // A mesh of the scene that the node's skin and weights deform; `source` is the node's JSON.
  Status deform(std::uint32_t number, const GltfObject& source, std::uint32_t scene_mesh,
                const GltfDeformation& how);

  // Reads skins and animations. A scene in which nothing is animated is brought to its rest pose.
  Status finish();

 private:
  // Where the joints of a skin lie in the motion.
  struct Joints {
    std::uint32_t first = 0, count = 0;
  };

  Status read_joints();
  Result<Joints> joints_of(std::uint32_t skin_index);
  Status read_animation(const GltfObject& source);
  Status read_channel(const GltfObject& animation, const GltfObject& channel,
                      const std::vector<GltfObject>& samplers);
  Status read_keys(const GltfObject& sampler, MotionChannel channel);
  void leave_out_still();

  GltfDocument& document_;
  Scene& scene_;
  SceneAnimation motion_;
  std::map<std::uint32_t, Joints> joints_;          // by skin, of those that were read
  std::map<std::uint32_t, std::uint32_t> numbers_;  // node of the file -> number
  std::vector<std::uint32_t> skins_;                // [deformed mesh], kNoIndex: none
  std::vector<std::uint32_t> joint_counts_;         // [deformed mesh], that it asks for
};

}  // namespace tessera::import
