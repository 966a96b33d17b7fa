// SPDX-License-Identifier: Apache-2.0
// Scenes of boxes: closed or open rooms, solids, walls with two sides. For tests of cameras that
// show a scene. Threads. Plain values.
#pragma once

#include <memory>
#include <vector>

#include "common/scene/scene.h"

namespace tessera::test {

// Sides of a box, as bits: the side at the lower or upper end of an axis.
enum Side : unsigned {
  kLeft = 1,
  kRight = 2,
  kBottom = 4,
  kTop = 8,
  kFar = 16,   // -z
  kFront = 32  // +z
};

class BoxScene {
 public:
  BoxScene() { scene_.materials.resize(1); }

  // Adds a box whose fronts face outward, or inward. `without`: sides that are left out.
  BoxScene& box(Vec3f lower, Vec3f upper, bool is_inward, unsigned without = 0) {
    const auto corner = [&](unsigned i) {
      return Vec3f{i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z};
    };
    // Corners counter-clockwise as seen from outside, in the order of Side.
    constexpr unsigned kSides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (unsigned side = 0; side < 6; ++side) {
      if (without >> side & 1) continue;
      const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
      for (const unsigned i : kSides[side]) mesh_.positions.push_back(corner(i));
      if (is_inward) {
        mesh_.triangles.push_back({first, first + 2, first + 1});
        mesh_.triangles.push_back({first, first + 3, first + 2});
      } else {
        mesh_.triangles.push_back({first, first + 1, first + 2});
        mesh_.triangles.push_back({first, first + 2, first + 3});
      }
    }
    return *this;
  }

  // Adds walls of a thickness around a room.
  BoxScene& house(Vec3f lower, Vec3f upper, float thickness, unsigned without = 0) {
    const Vec3f wall{thickness, thickness, thickness};
    return box(lower, upper, false, without).box(lower + wall, upper - wall, true, without);
  }

  Scene scene() const {
    Scene result = scene_;
    Mesh mesh = mesh_;
    mesh.materials = {0};
    result.meshes = {std::make_shared<const Mesh>(mesh)};
    result.instances.resize(1);
    return result;
  }

 private:
  Scene scene_;
  Mesh mesh_;
};

}  // namespace tessera::test
