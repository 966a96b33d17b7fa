// SPDX-License-Identifier: Apache-2.0
// Property: a scene whose meshes are instanced gives the bits of the same scene flattened, whatever
// the transforms, for single rays, bundles and fans, closest and any hit, on every instruction set.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/flattened_twin.h"
#include "tests/support/hard_cases.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }

struct Class {
  const char* name;
  float scale_low, scale_high;  // exponents of ten
  float shear;
  float far;  // from the world's origin, in units of the scene
  bool is_mirrored = false;
  bool is_uneven = false;  // axes are scaled apart by up to 1e4
};

constexpr Class kClasses[] = {{"identity", 0, 0, 0, 0},
                              {"turned", 0, 0, 0, 0},
                              {"mirrored", 0, 0, 0, 0, true},
                              {"sheared", 0, 0, 3, 0},
                              {"tiny", -6, -6, 0.2f, 0},
                              {"huge", 6, 6, 0.2f, 0},
                              {"uneven", 0, 0, 0.5f, 0, true, true},
                              {"far", 0, 0, 0.3f, 1e5f},
                              {"mixed", -3, 3, 1, 10, true}};

// A rotation with scale and shear into a cell of a grid, so that instances stand apart but touch.
Transform transform_of(const Class& c, int number, Random& random) {
  Transform t;
  if (std::string_view(c.name) == "identity" && number == 0) return t;
  Vec3f axis = normalize(Vec3f{unit(random), unit(random), unit(random)});
  const float angle = 3 * unit(random), cosine = std::cos(angle), sine = std::sin(angle);
  const float n[3] = {axis.x, axis.y, axis.z};
  const float middle = (c.scale_low + c.scale_high) / 2;
  const float spread = (c.scale_high - c.scale_low) / 2;
  const float scale = std::pow(10.0f, middle + spread * unit(random));
  const float all = std::pow(10.0f, middle);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t k = 3 - i - j;
      float r = n[i] * n[j] * (1 - cosine) + (i == j ? cosine : 0);
      if (i != j) r += ((j + 3 - i) % 3 == 1 ? -1.0f : 1.0f) * sine * n[k];
      t.m[i][j] = r;
    }
  }
  Transform by;
  by.m[0][1] = c.shear * unit(random);
  by.m[1][2] = c.shear * unit(random);
  if (c.is_mirrored) by.m[0][0] = -1;
  if (c.is_uneven) by.m[1][1] = std::pow(10.0f, 2 * unit(random));
  t = t * by;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) t.m[i][j] *= scale;
    t.m[i][3] = all * (2 * unit(random) + c.far);
  }
  return t;
}

Scene scene_of(const Class& c, const std::vector<Mesh>& meshes, Random& random) {
  Scene scene = test::make_scene(meshes[0]);
  scene.instances.clear();
  for (std::size_t m = 1; m < meshes.size(); ++m)
    scene.meshes.push_back(std::make_shared<const Mesh>(meshes[m]));
  for (int i = 0; i < 9; ++i) {
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(i) % static_cast<std::uint32_t>(meshes.size());
    instance.object_to_world = transform_of(c, i, random);
    scene.instances.push_back(instance);
  }
  return scene;
}

std::shared_ptr<const PreparedScene> prepared(const Scene& scene, Instancing instancing) {
  BuildOptions options;
  options.instancing = instancing;
  auto built = PreparedScene::build(scene, options);
  EXPECT_TRUE(built.is_ok());
  return *built;
}

class Instances : public testing::TestWithParam<Class> {};

TEST_P(Instances, GiveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  const std::vector<Mesh> meshes = {test::make_icosphere(3), test::make_terrain(20, 3),
                                    test::make_random_triangles(500, 0.3f, 5)};
  const Scene scene = scene_of(GetParam(), meshes, random);
  const auto flat = prepared(scene, Instancing::kNever);
  const auto instanced = prepared(scene, Instancing::kAlways);
  EXPECT_TRUE(flat->impl().triangles.is_flat());
  ASSERT_FALSE(instanced->impl().triangles.is_flat());
  EXPECT_EQ(flat->primitive_count(), instanced->primitive_count());
  const std::vector<CastRay> rays = test::rays_around(flat->impl().triangles, 64 * 96, random);
  EXPECT_GT(test::compare_with_flattened(*flat, *instanced, rays), rays.size());
}

INSTANTIATE_TEST_SUITE_P(Transforms, Instances, testing::ValuesIn(kClasses),
                         [](const auto& info) { return std::string(info.param.name); });

// Rays that meet more instances than a ray of a stream keeps, all in all and each by itself, and
// rays that meet few.
TEST(Instances, InARowGiveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  for (const int count : {2, 12, 40, 300}) {
    Scene scene = test::make_scene(test::make_random_triangles(24, 0.2f, seed));
    const Instance first = scene.instances[0];
    for (int i = 1; i < count; ++i) {
      Instance next = first;
      next.object_to_world.m[0][3] = 0.5f * static_cast<float>(i);
      next.object_to_world.m[1][2] = 0.1f * unit(random);
      scene.instances.push_back(next);
    }
    const auto flat = prepared(scene, Instancing::kNever);
    const auto instanced = prepared(scene, Instancing::kAlways);
    std::vector<CastRay> rays = test::rays_around(flat->impl().triangles, 64 * 8, random);
    for (int i = 0; i < 64 * 16; ++i) {
      const float y = unit(random), z = unit(random), slope = i % 128 < 64 ? 0.01f : 1.0f;
      rays.push_back({Vec3f{-2, y, z}, Vec3f{1, slope * unit(random), slope * unit(random)}, 0,
                      std::numeric_limits<float>::infinity()});
    }
    EXPECT_GT(test::compare_with_flattened(*flat, *instanced, rays), 0u) << count;
  }
}

// Of the instances that such a ray meets some lie before it and some behind, at negative distances;
// or it begins at its origin, written as -0.
TEST(Instances, BehindTheOriginOfARayGiveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  Scene scene = test::make_scene(test::make_random_triangles(200, 0.3f, seed));
  const Instance first = scene.instances[0];
  for (int i = 1; i < 6; ++i) {
    Instance next = first;
    next.object_to_world.m[0][3] = 3 * static_cast<float>(i);
    scene.instances.push_back(next);
  }
  const auto flat = prepared(scene, Instancing::kNever);
  const auto instanced = prepared(scene, Instancing::kAlways);
  std::vector<CastRay> rays;
  for (int i = 0; i < 64 * 64; ++i) {
    const float x = 7.5f + 6 * unit(random);
    rays.push_back({Vec3f{x, 0.5f * unit(random), 0.5f * unit(random)},
                    Vec3f{1, 0.05f * unit(random), 0.05f * unit(random)},
                    i % 128 < 64 ? -20.0f : -0.0f, std::numeric_limits<float>::infinity()});
  }
  EXPECT_GT(test::compare_with_flattened(*flat, *instanced, rays), rays.size() / 2);
}

// Hard rays of each class, and their mesh in its place and sheared beside it.
class HardInstances : public testing::TestWithParam<std::string> {};

TEST_P(HardInstances, GiveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  const test::HardCase hard = test::make_hard_case(GetParam(), 64 * 128, seed);
  Scene scene = test::make_scene(hard.mesh);
  Instance moved = scene.instances[0];
  moved.object_to_world.m[0][3] = 0.001f;
  moved.object_to_world.m[1][0] = 0.25f;
  scene.instances.push_back(moved);
  const auto flat = prepared(scene, Instancing::kNever);
  const auto instanced = prepared(scene, Instancing::kAlways);
  std::vector<CastRay> rays;
  for (const test::Ray& ray : hard.rays)
    rays.push_back({ray.origin, ray.direction, ray.t_min, ray.t_max});
  test::compare_with_flattened(*flat, *instanced, rays);
}

INSTANTIATE_TEST_SUITE_P(Cases, HardInstances, testing::ValuesIn(test::hard_case_names()),
                         [](const auto& info) {
                           std::string name = info.param;
                           for (char& c : name)
                             c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

TEST(Instances, WithoutInverseAreFlattened) {
  Scene scene = test::make_scene(test::make_icosphere(2));
  Instance thin = scene.instances[0];
  thin.object_to_world.m[1][1] = 0;  // a disk
  Instance vast = scene.instances[0];
  vast.object_to_world.m[0][0] = 1e32f;
  scene.instances.push_back(thin);
  scene.instances.push_back(vast);
  const auto instanced = prepared(scene, Instancing::kAlways);
  const auto& stored = instanced->impl().triangles.stored_first;
  EXPECT_EQ(stored[0], TriangleStore::kNotStored);
  EXPECT_EQ(stored[1], 0u);
  EXPECT_NE(stored[2], TriangleStore::kNotStored);
  Random random(3);
  const std::vector<CastRay> rays = test::rays_around(instanced->impl().triangles, 64 * 16, random);
  test::compare_with_flattened(*prepared(scene, Instancing::kNever), *instanced, rays);
}

TEST(Instances, ShareTheirMeshAndTakeLittleMemory) {
  const Mesh mesh = test::make_icosphere(5);
  const auto memory = [&](std::uint32_t count) {
    Scene scene = test::make_scene(mesh);
    const Instance first = scene.instances[0];
    for (std::uint32_t i = 1; i < count; ++i) {
      Instance instance = first;
      instance.object_to_world.m[0][3] = static_cast<float>(3 * (i % 30));
      instance.object_to_world.m[2][3] = static_cast<float>(3 * (i / 30));
      scene.instances.push_back(instance);
    }
    return prepared(scene, count == 1 ? Instancing::kNever : Instancing::kAlways)->memory_bytes();
  };
  const std::uint64_t one = memory(1), many = memory(900);
  EXPECT_LE(many, one + one / 10 + 900 * 300) << "one: " << one << ", 900: " << many;
}

TEST(Instances, ThatMoveBuildNoMeshAgain) {
  Scene scene = test::make_scene(test::make_icosphere(4));
  scene.instances.push_back(scene.instances[0]);
  scene.instances[1].object_to_world.m[0][3] = 3;
  const auto before = prepared(scene, Instancing::kAlways);
  scene.instances[0].object_to_world.m[1][3] = 1;
  BuildOptions options;
  options.instancing = Instancing::kAlways;
  options.other = before.get();
  const auto after = PreparedScene::build(scene, options);
  ASSERT_TRUE(after.is_ok());
  const auto mesh_of = [](const PreparedScene& prepared) {
    return std::visit(
        [](const auto& index) -> const void* {
          if constexpr (requires { index.meshes; }) return index.meshes[0].get();
          return nullptr;
        },
        prepared.impl().index.any);
  };
  EXPECT_NE(mesh_of(*before), nullptr);
  EXPECT_EQ(mesh_of(*before), mesh_of(**after));
  Random random(4);
  const std::vector<CastRay> rays = test::rays_around((*after)->impl().triangles, 64 * 32, random);
  EXPECT_GT(test::compare_with_flattened(*prepared(scene, Instancing::kNever), **after, rays), 0u);
}

TEST(Instances, ArePicturedAsTheFlattenedScene) {
  for (const Scene& scene : {test::make_full_scene(), test::make_scene_of_all_materials()}) {
    const auto flat = prepared(scene, Instancing::kNever);
    const auto instanced = prepared(scene, Instancing::kAlways);
    ASSERT_FALSE(instanced->impl().triangles.is_flat());
    FrameSettings settings;
    settings.width_px = 80;
    settings.height_px = 60;
    if (scene.camera) settings.camera = *scene.camera;
    for (const Renderer renderer :
         {Renderer::kPrimary, Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
      settings.renderer = renderer;
      const TileRect rect{0, 0, 80, 60};
      std::vector<float> wanted(3 * 80 * 60), found = wanted;
      TileRenderer tiles;
      tiles.render(*flat, settings, test::isas_here().back(), rect, wanted, nullptr, nullptr);
      tiles.render(*instanced, settings, test::isas_here().back(), rect, found, nullptr, nullptr);
      EXPECT_EQ(wanted, found) << static_cast<int>(renderer);
    }
  }
}

}  // namespace
}  // namespace tessera::core
