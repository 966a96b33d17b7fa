// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/edited_scenes.h"

#include <array>
#include <bit>
#include <memory>
#include <utility>
#include <vector>

#include "slave/core/scene/ray_caster.h"
#include "tests/sim/picture.h"
#include "tests/sim/random.h"

namespace tessera::sim {
namespace {

constexpr int kCloths = kSceneTagsMax / 2;  // tags of the cloth; the others are of objects
constexpr int kClothSide = 9, kObjectSide = 4;
constexpr int kObjectMeshes = 4;
constexpr std::size_t kObjectsMin = 4, kObjectsMax = 9;
constexpr int kRaysAcross = 8;

// A square over [0, 1] in x and y with random heights.
Mesh rough_square(Random& random, int side) {
  Mesh mesh;
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) {
      mesh.positions.push_back({static_cast<float>(x) / static_cast<float>(side),
                                static_cast<float>(y) / static_cast<float>(side),
                                static_cast<float>(random.between(0, 0.4))});
    }
  }
  const auto row = static_cast<std::uint32_t>(side) + 1;
  for (std::uint32_t y = 0; y + 1 < row; ++y) {
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t at = y * row + x;
      mesh.triangles.push_back({at, at + 1, at + row});
      mesh.triangles.push_back({at + 1, at + row + 1, at + row});
    }
  }
  mesh.materials = {0};
  return mesh;
}

void move_corners(Random& random, Mesh& mesh) {
  for (Vec3f& corner : mesh.positions) corner.z += static_cast<float>(random.between(-0.05, 0.05));
}

Scene scene_of(std::shared_ptr<const Mesh> mesh) {
  Scene scene;
  scene.meshes = {std::move(mesh)};
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  return scene;
}

// Moves corners, or takes triangles away, or puts back what was taken.
void edit_cloth(Random& random, const Mesh& whole, Scene& scene) {
  Mesh mesh = *scene.meshes[0];
  const std::size_t count = mesh.triangles.size();
  if (!random.chance(0.4)) {
    move_corners(random, mesh);
  } else if (count < whole.triangles.size()) {
    mesh.triangles = whole.triangles;
  } else {
    mesh.triangles.resize(count - count / static_cast<std::size_t>(random.pick(2, 5)));
  }
  scene.meshes[0] = std::make_shared<const Mesh>(std::move(mesh));
}

Transform place(Random& random) {
  Transform to_world;
  for (std::size_t a = 0; a < 3; ++a) {
    to_world.m[a][a] = static_cast<float>(random.between(0.3, 0.6));
    to_world.m[a][3] = static_cast<float>(random.between(0, 0.5));
  }
  return to_world;
}

Instance object(Random& random) {
  return {static_cast<std::uint32_t>(random.pick(0, kObjectMeshes - 1)), place(random)};
}

Scene first_objects(Random& random) {
  Scene scene;
  for (int m = 0; m < kObjectMeshes; ++m)
    scene.meshes.push_back(std::make_shared<const Mesh>(rough_square(random, kObjectSide)));
  scene.materials.emplace_back();
  while (scene.instances.size() < kObjectsMin) scene.instances.push_back(object(random));
  return scene;
}

void edit_objects(Random& random, Scene& scene) {
  const auto any =
      static_cast<std::size_t>(random.pick(0, static_cast<int>(scene.instances.size()) - 1));
  const double what = random.unit();
  if (what < 0.5) {
    scene.instances[any].object_to_world = place(random);
  } else if (what < 0.6) {
    for (Instance& instance : scene.instances) instance.object_to_world = place(random);
  } else if (what < 0.75) {
    Mesh mesh = *scene.meshes[scene.instances[any].mesh];
    move_corners(random, mesh);
    scene.meshes[scene.instances[any].mesh] = std::make_shared<const Mesh>(std::move(mesh));
  } else if (scene.instances.size() < kObjectsMax && (what < 0.9 || any < kObjectsMin)) {
    scene.instances.push_back(object(random));
  } else {
    scene.instances.erase(scene.instances.begin() + static_cast<std::ptrdiff_t>(any));
  }
}

std::vector<Scene> make_scenes() {
  Random random(0x6564697473u);
  const Mesh cloth = rough_square(random, kClothSide);
  std::vector<Scene> scenes{scene_of(std::make_shared<const Mesh>(cloth))};
  while (static_cast<int>(scenes.size()) < kSceneTagsMax) {
    const bool is_first = static_cast<int>(scenes.size()) == kCloths;
    Scene scene = is_first ? first_objects(random) : scenes.back();
    if (static_cast<int>(scenes.size()) < kCloths) {
      edit_cloth(random, cloth, scene);
    } else if (!is_first) {
      edit_objects(random, scene);
    }
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

// From above, not quite straight down, over the whole square.
std::array<core::CastRay, kRaysAcross * kRaysAcross> make_rays() {
  std::array<core::CastRay, kRaysAcross * kRaysAcross> rays;
  Random random(0x72617973u);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto x =
        static_cast<float>((static_cast<double>(i % kRaysAcross) + random.unit()) / kRaysAcross);
    const auto y =
        static_cast<float>((static_cast<double>(i / kRaysAcross) + random.unit()) / kRaysAcross);
    rays[i] = {{x, y, 4}, {static_cast<float>(random.between(-0.02, 0.02)), 0, -1}, 0, 100};
  }
  return rays;
}

}  // namespace

Scene edited_scene(int tag) {
  static const std::vector<Scene> scenes = make_scenes();
  return scenes[static_cast<std::size_t>(tag)];
}

std::uint64_t met_by_rays(const core::PreparedScene& scene) {
  static const auto rays = make_rays();
  std::array<core::CastHit, kRaysAcross * kRaysAcross> hits;
  core::cast_rays(scene, rays, {}, hits);
  std::uint64_t met = 0;
  for (const core::CastHit& hit : hits) {
    met = mix(met ^ (std::uint64_t{hit.primitive} << 1 | (hit.is_hit ? 1u : 0u)));
    met = mix(met ^ (std::uint64_t{std::bit_cast<std::uint32_t>(hit.t)} << 32 |
                     std::bit_cast<std::uint32_t>(hit.u)));
  }
  return met;
}

}  // namespace tessera::sim
