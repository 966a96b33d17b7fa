// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/deform_scene.h"

#include <cmath>
#include <memory>
#include <utility>

#include "master/loader/builtin.h"
#include "tests/bench/shape_builder.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {

Deforming waves() {
  const auto loaded = std::make_shared<master::LoadedScene>(*master::make_builtin("waves"));
  return {"waves",
          [loaded](float t) { return loaded->at_time(double{t}); },
          *loaded->scene.camera,
          {-6, 9, 7}};
}

Deforming swell() {
  const auto at = [](float t) {
    constexpr int kCells = 708;
    ShapeBuilder b;
    b.add_surface(kCells, kCells, [t](float u, float v) {
      const float x = 12 * (u - 0.5f), z = -12 * (v - 0.5f);
      const float y = 0.25f * std::sin(1.3f * x + 1.7f * t) +
                      0.18f * std::sin(0.9f * z - 1.1f * x + 2.3f * t) +
                      0.06f * std::sin(4.1f * x + 3.3f * z + 4 * t);
      return Vec3f{x, y, z};
    });
    Mesh mesh = b.take();
    mesh.materials = {0};
    return test::make_scene(std::move(mesh));
  };
  return {"swell", at, Camera{{0, 3.2f, 8.5f}, {0, -0.3f, 0}, {0, 1, 0}, 42}, {-6, 9, 7}};
}

}  // namespace tessera::bench
