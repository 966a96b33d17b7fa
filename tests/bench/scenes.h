// SPDX-License-Identifier: Apache-2.0
// The four scenes of the benchmark. They are generated, and the same to the bit as those that the
// figures of other ray tracers were taken on (checked by digest, scenes_test.cpp).
//
//   interior  287,284 triangles  a furnished hall with many thin parts (for the thesis' Conference)
//   knot      686,188            smooth curved objects, mostly open space (Beetle)
//   building  2,304,786          many rooms, most of them hidden (Soda Hall)
//   field     10 million         terrain with boulders and posts; a triangle is less than a pixel
//   crowd     1.7 million        400 instances of one figure, by name only
//
// Threads. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/scene/camera.h"
#include "common/scene/scene.h"

namespace tessera::bench {

struct BenchScene {
  std::string name;
  Mesh mesh;
  Camera camera;
  Vec3f light;  // a point light, for shadow rays
  // Meshes and instances of a scene that has instances; `mesh` is empty then.
  std::vector<Mesh> meshes{};
  std::vector<Instance> instances{};
};

std::vector<std::string> scene_names();  // of the scenes without instances
// Returns: the scene, or kInvalidArgument with the names that exist.
Result<BenchScene> make_scene(const std::string& name);

}  // namespace tessera::bench
