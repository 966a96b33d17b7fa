// SPDX-License-Identifier: Apache-2.0
// What a slave takes to prepare a scene stays below what the master reckons (scene_footprint.h). It
// is measured as the peak of a process of its own, for each structure.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <random>

#include "common/scene/scene_footprint.h"
#include "master/loader/builtin_teapot_data.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

// A field of random heights, which make trees large.
Scene rough_field(std::uint32_t side) {
  std::mt19937 random(test::seed(3));
  std::uniform_real_distribution<float> height(0, 5);
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      mesh->positions.push_back({static_cast<float>(x), static_cast<float>(y), height(random)});
    }
  }
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t i = y * side + x;
      mesh->triangles.push_back({i, i + 1, i + side});
      mesh->triangles.push_back({i + 1, i + side + 1, i + side});
    }
  }
  mesh->materials = {0};
  Scene scene;
  scene.meshes = {mesh};
  scene.materials.resize(1);
  scene.instances = {{0, Transform{}}};
  return scene;
}

std::uint64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

// Teapots beside each other, each of 32 patches.
Scene teapots(std::uint32_t count) {
  auto surface = std::make_shared<PatchSurface>();
  for (const auto& indices : master::kTeapotPatches) {
    surface->patches.push_back({3, 3, 0, 0});
    for (const std::uint16_t i : indices) {
      surface->numbers.insert(surface->numbers.end(), std::begin(master::kTeapotPoints[i]),
                              std::end(master::kTeapotPoints[i]));
    }
  }
  surface->materials = {0};
  Scene scene;
  scene.surfaces = {surface};
  scene.materials.resize(1);
  for (std::uint32_t i = 0; i < count; ++i) {
    scene.instances.push_back({0, Transform{}, ObjectKind::kPatchSurface});
    scene.instances.back().object_to_world.m[0][3] = 8 * static_cast<float>(i);
  }
  return scene;
}

// Returns: by how much preparing the scene lets the peak of a process rise; 0 where it fails.
std::uint64_t bytes_taken(const Scene& scene, Structure structure) {
  int ends[2] = {};
  if (pipe(ends) != 0) return 0;
  const pid_t child = fork();
  if (child == 0) {
    malloc_trim(0);
    const std::uint64_t before = peak_bytes();
    const auto prepared = PreparedScene::build(scene, {2, nullptr, structure});
    const std::uint64_t taken = prepared.is_ok() ? peak_bytes() - before : 0;
    _exit(write(ends[1], &taken, sizeof(taken)) == sizeof(taken) ? 0 : 1);
  }
  close(ends[1]);
  std::uint64_t taken = 0;
  if (read(ends[0], &taken, sizeof(taken)) != static_cast<ssize_t>(sizeof(taken))) taken = 0;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return taken;
}

class SceneMemory : public testing::TestWithParam<Structure> {};

TEST_P(SceneMemory, PreparingStaysBelowTheReckoning) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  const Scene scene = rough_field(500);
  const std::uint64_t reckoned = index_bytes_of(SceneEncoder().encode(scene));
  ASSERT_EQ(reckoned, kIndexBytesPerTriangle * scene.triangle_count());
  const std::uint64_t taken = bytes_taken(scene, GetParam());
  const double each = static_cast<double>(taken) / static_cast<double>(scene.triangle_count());
  std::printf("%.0f bytes a triangle at the peak, %llu reckoned\n", each,
              static_cast<unsigned long long>(kIndexBytesPerTriangle));
  EXPECT_GT(taken, 0u);
  EXPECT_LE(taken, reckoned);
  EXPECT_GE(4 * taken, reckoned) << "far too cautious";
}

class PatchMemory : public SceneMemory {};

TEST_P(PatchMemory, PreparingStaysBelowTheReckoning) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  const Scene scene = teapots(60);
  const std::uint64_t reckoned = index_bytes_of(SceneEncoder().encode(scene));
  const std::uint64_t taken = bytes_taken(scene, GetParam());
  const auto count = static_cast<double>(scene.patch_count());
  std::printf("%.0f bytes a patch at the peak, %.0f reckoned\n", static_cast<double>(taken) / count,
              static_cast<double>(reckoned) / count);
  EXPECT_GT(taken, 0u);
  EXPECT_LE(taken, reckoned);
  EXPECT_GE(4 * taken, reckoned) << "far too cautious";
}

INSTANTIATE_TEST_SUITE_P(Structures, SceneMemory,
                         testing::Values(Structure::kAuto, Structure::kBvh, Structure::kBvhQuality,
                                         Structure::kKd));
// Kd-trees hold no patches.
INSTANTIATE_TEST_SUITE_P(Structures, PatchMemory,
                         testing::Values(Structure::kAuto, Structure::kBvh,
                                         Structure::kBvhQuality));

}  // namespace
}  // namespace tessera::core
