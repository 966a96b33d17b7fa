// SPDX-License-Identifier: Apache-2.0
// The scene of a time: nodes placed by the first clip's curves, instances, lights and cameras moved
// with them, meshes deformed by morph targets and then by skins (glTF 2.0, sections 3.7.3, 3.11).
//
// All is computed in double by operations that every processor rounds alike, and rounded to float
// once, so that master and slaves have the same bits. What two times share is the same object: a
// mesh whose joints and weights did not move is not made again, and so not built again.
//
// Accuracy. A position is off by the roundings of one chain of matrices in double, some 1e-15 of
// the largest place on the way for each node above it, and by one rounding to float.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/api.h"
#include "common/base/status.h"
#include "common/scene/animation.h"
#include "common/scene/scene.h"

namespace tessera {

// The place of a node below its parent at rest, rounded to float once. Pure.
TESSERA_API Transform rest_place(const MotionNode& node);

// The camera of a node: at its place, along its -z axis, with +y up. Pure.
TESSERA_API Camera camera_of(const Transform& to_world, float vfov_degrees);

// Where a camera of the scene is at a time. Returns: nothing where no node carries it, or none can
// stand there. Requires: as ScenePoser::at(). Pure.
TESSERA_API std::optional<Camera> moved_camera(const Scene& scene, std::size_t camera,
                                               double seconds);

// Threads. One at a time.
class TESSERA_API ScenePoser {
 public:
  // The scene at a time; the scene itself where nothing of it moves. Instances whose place has no
  // inverse then (a scale of 0 hides an object) are left out.
  // Returns: kInvalidArgument naming what is not finite at this time.
  // Requires: validate_scene(scene) was ok; seconds is finite.
  Result<Scene> at(const Scene& scene, double seconds);

 private:
  // A mesh as it was deformed last.
  struct Known {
    std::shared_ptr<const Mesh> rest, deformed;
    std::vector<double> inputs;  // weights, and the matrices of the joints
  };
  std::vector<Known> known_;                         // [deformed mesh]
  std::shared_ptr<const SceneAnimation> animation_;  // by which they were
};

}  // namespace tessera
