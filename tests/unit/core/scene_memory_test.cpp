// SPDX-License-Identifier: Apache-2.0
// What a slave takes to prepare a scene stays below what the master reckons (scene_footprint.h). It
// is measured as the peak of a process of its own, for each structure.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <random>
#include <span>
#include <string>

#include "common/scene/animation.h"
#include "common/scene/scene_footprint.h"
#include "master/loader/builtin.h"
#include "master/loader/builtin_teapot_data.h"
#include "slave/core/scene/patch_footprint.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/support/seed.h"
#include "tests/support/trim_shapes.h"

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

// The most that this process has had since forget_peak().
std::uint64_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  std::uint64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:" && status >> kib) break;
  }
  return kib * 1024;
}

// What a process inherits from the one that it is forked from counts as its own, until then.
void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
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
    forget_peak();
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

TEST(InstanceMemory, PreparingStaysBelowTheReckoning) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  Scene scene = rough_field(23);
  for (int i = 1; i < 100'000; ++i) {
    scene.instances.push_back(scene.instances[0]);
    scene.instances.back().object_to_world.m[i % 2][3] = 30 * static_cast<float>(i / 2);
  }
  const std::uint64_t reckoned = index_bytes_of(SceneEncoder().encode(scene));
  const std::uint64_t taken = bytes_taken(scene, Structure::kAuto);
  std::printf("%.0f bytes an instance at the peak, %llu reckoned\n",
              static_cast<double>(taken) / static_cast<double>(scene.instances.size()),
              static_cast<unsigned long long>(kIndexBytesPerInstance));
  EXPECT_GT(taken, 0u);
  EXPECT_LE(taken, reckoned);
  EXPECT_GE(4 * taken, reckoned) << "far too cautious";
}

TEST(InstanceMemory, CopiesThatShedLightAreReckonedOneByOne) {
  Scene scene = rough_field(23);
  for (int i = 1; i < 1000; ++i) scene.instances.push_back(scene.instances[0]);
  const std::uint64_t shared = index_bytes_of(SceneEncoder().encode(scene));
  scene.materials[0].emission = {1, 1, 1};
  const std::uint64_t copied = index_bytes_of(SceneEncoder().encode(scene));
  EXPECT_EQ(copied, kIndexBytesPerTriangle * scene.triangle_count());
  EXPECT_LT(100 * shared, copied);
}

TEST(InstanceMemory, WhatSlavesCopyIsReckonedCopyByCopy) {
  Scene scene = rough_field(23);
  for (int i = 1; i < 1000; ++i) scene.instances.push_back(scene.instances[0]);
  const std::uint64_t shared = index_bytes_of(SceneEncoder().encode(scene));
  const std::uint64_t each = kIndexBytesPerTriangle * scene.meshes[0]->triangles.size();

  Scene flat = scene;
  for (int i = 1; i < 1000; ++i)
    flat.instances[static_cast<std::size_t>(i)].object_to_world.m[2][2] = 0;
  EXPECT_EQ(index_bytes_of(SceneEncoder().encode(flat)), shared + 999 * each);

  Scene with_patches = teapots(1);
  with_patches.meshes = scene.meshes;
  with_patches.instances.insert(with_patches.instances.end(), scene.instances.begin(),
                                scene.instances.end());
  EXPECT_GE(index_bytes_of(SceneEncoder().encode(with_patches)), 1000 * each);
}

TEST(InstanceMemory, AKdTreeThatCopiesMoreThanThereIsRoomForIsRefused) {
  Scene scene = rough_field(23);
  const auto copies = [&](std::size_t count) {
    scene.instances.assign(count, scene.instances[0]);
    for (std::size_t i = 0; i < count; ++i)
      scene.instances[i].object_to_world.m[0][3] = 30 * static_cast<float>(i);
  };
  const auto said = [&](Structure structure, std::uint64_t free) {
    BuildOptions options{2, nullptr, structure};
    options.free_bytes = [free] { return std::optional(free); };
    return PreparedScene::build(scene, options).status().message();
  };
  copies(600);  // 580,800 triangles: 178 MiB as copies, less than 1 as instances
  EXPECT_EQ(said(Structure::kKd, 100 << 20),
            "a kd-tree of the scene needs 178 MiB of memory here, 100 MiB are free: it copies what "
            "--structure auto shares");
  EXPECT_EQ(said(Structure::kAuto, 100 << 20), "");
  copies(10);  // reckoned as copies by whoever sent it
  EXPECT_EQ(said(Structure::kKd, 1 << 20), "");
}

// As many teapots as one surface.
Scene teapots_apart(std::uint32_t count) {
  Scene scene = teapots(1);
  auto all = std::make_shared<PatchSurface>();
  for (std::uint32_t i = 0; i < count; ++i) {
    for (const PatchForm& form : scene.surfaces[0]->patches) all->patches.push_back(form);
    for (std::size_t n = 0; n < scene.surfaces[0]->numbers.size(); ++n) {
      const float shift = n % 3 == 0 ? 8 * static_cast<float>(i % 64) : 0;
      all->numbers.push_back(scene.surfaces[0]->numbers[n] + shift);
    }
  }
  all->materials = {0};
  scene.surfaces = {all};
  return scene;
}

// Flat squares beside pipes of few and of many parts, by turns, half of them without order.
Scene mixed_patches(std::uint32_t count) {
  std::mt19937 random(test::seed(4));
  std::uniform_real_distribution<float> height(0, 2);
  auto surface = std::make_shared<PatchSurface>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool is_flat = i % 2 == 0;
    const std::uint8_t degree = is_flat ? 1 : 3;
    surface->patches.push_back({degree, degree, 0, 0});
    for (int row = 0; row <= degree; ++row) {
      for (int column = 0; column <= degree; ++column) {
        const float z = is_flat ? 0 : height(random);
        for (const float x :
             {4 * static_cast<float>(i) + static_cast<float>(row), static_cast<float>(column), z})
          surface->numbers.push_back(x);
      }
    }
  }
  surface->materials = {0};
  Scene scene = teapots(1);
  scene.surfaces = {surface};
  return scene;
}

// Pipes with a hole each, whose border is widened; by turns of one and of twelve segments.
Scene pipes_with_holes(std::uint32_t count) {
  Scene scene = mixed_patches(count);
  PatchSurface holes = *scene.surfaces[0];
  for (std::uint32_t i = 0; i < count; ++i) {
    holes.patches[i].keeps_outside = 1;
    holes.loop_counts.push_back(0);
    for (std::uint32_t loop = 0; loop < (i % 2 == 0 ? 1u : 12u); ++loop)
      test::add_circle(holes, 0.5f, 0.5f, 0.02f + 0.03f * static_cast<float>(loop));
  }
  for (std::size_t i = 0; i < holes.degrees.size(); ++i) holes.trim_widths.push_back(1e-5f);
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(holes))};
  return scene;
}

// One patch with very many loops, one in the other.
Scene rings(std::uint32_t count) {
  Scene scene = teapots(1);
  PatchSurface surface = test::plain_patch(true);
  for (std::uint32_t i = 0; i < count; ++i)
    test::add_circle(surface, 0.5f, 0.5f,
                     0.49f * (static_cast<float>(i) + 0.5f) / static_cast<float>(count));
  for (std::size_t i = 0; i < surface.degrees.size(); ++i) surface.trim_widths.push_back(1e-5f);
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(surface))};
  return scene;
}

class PatchMemory : public SceneMemory {
 protected:
  void expect_near(const Scene& scene) {
    const std::uint64_t reckoned =
        index_bytes_of(SceneEncoder().encode(scene), PatchFootprint().surface_bytes());
    const std::uint64_t taken = bytes_taken(scene, GetParam());
    const auto count = static_cast<double>(scene.patch_count());
    std::printf("%.0f patches: %.0f bytes each at the peak, %.0f reckoned\n", count,
                static_cast<double>(taken) / count, static_cast<double>(reckoned) / count);
    EXPECT_GT(taken, 0u);
    EXPECT_LE(taken, reckoned);
    EXPECT_GE(1.6 * static_cast<double>(taken) + (4 << 20), static_cast<double>(reckoned))
        << "far too cautious";
  }
};

TEST_P(PatchMemory, PreparingIsReckonedNearly) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  for (const std::uint32_t count : {1u, 20u, 200u, 2000u}) expect_near(teapots(count));
  for (const std::uint32_t count : {20u, 3000u}) expect_near(teapots_apart(count));
  for (const std::uint32_t count : {400u, 2000u}) expect_near(mixed_patches(count));
  expect_near(master::make_cones().scene);
  for (const std::uint32_t count : {100u, 3000u}) expect_near(pipes_with_holes(count));
}

// Places that share their surface. What threads keep of it comes with their first rays.
TEST(SharedPatchMemory, IsReckonedAsFlattenedWherePlacesMayMoveByThemselves) {
  Scene scene = teapots(3000);
  const std::uint64_t still = index_bytes_of(SceneEncoder().encode(scene));
  scene.animation = std::make_shared<const SceneAnimation>();
  EXPECT_GT(index_bytes_of(SceneEncoder().encode(scene)), 4 * still);
}

TEST(SharedPatchMemory, PreparingStaysBelowTheReckoning) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  const auto reckoned_of = [](const Scene& scene) {
    return index_bytes_of(SceneEncoder().encode(scene), PatchFootprint().surface_bytes());
  };
  Scene scene = teapots(30'000);
  const std::uint64_t tables = kPlacedPartsThreads * kPlacedPartsBytes;
  const std::uint64_t reckoned = reckoned_of(scene) - tables;
  const std::uint64_t taken = bytes_taken(scene, Structure::kAuto);
  std::printf("%.0f bytes a place at the peak, %.0f reckoned\n",
              static_cast<double>(taken) / 30'000, static_cast<double>(reckoned) / 30'000);
  EXPECT_GT(taken, 0u);
  EXPECT_LE(taken, reckoned);
  EXPECT_GE(4 * taken, reckoned) << "far too cautious";

  const std::uint64_t each = reckoned_of(teapots(2001)) - reckoned_of(teapots(2000));
  for (std::size_t i = 0; i < 500; ++i) scene.instances[i].object_to_world.m[2][2] = 0;
  for (std::size_t i = 500; i < 1000; ++i) scene.instances[i].object_to_world.m[0][3] = 1e9f;
  EXPECT_GE(reckoned_of(scene) - tables - reckoned, 900 * (each / 20)) << "these are flattened";
  scene.materials[0].emission = {1, 1, 1};
  EXPECT_GE(reckoned_of(scene), 20 * reckoned) << "each part is a lamp";
}

// Where nobody cuts patches, it is a bound.
TEST_P(PatchMemory, PreparingTrimsStaysBelowWhatIsAssumedOfThem) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory counts";
#endif
  for (const Scene& scene : {rings(1), rings(300), rings(1000), pipes_with_holes(1000)}) {
    const EncodedScene encoded = SceneEncoder().encode(scene);
    const std::uint64_t assumed = index_bytes_of(encoded);
    const std::uint64_t reckoned = index_bytes_of(encoded, PatchFootprint().surface_bytes());
    const std::uint64_t taken = bytes_taken(scene, GetParam());
    const auto points = static_cast<double>(primitive_counts_of(encoded).trim_points);
    std::printf("%.0f points of loops: %.0f bytes each at the peak, %.0f reckoned, %.0f assumed\n",
                points, static_cast<double>(taken) / points, static_cast<double>(reckoned) / points,
                static_cast<double>(assumed) / points);
    EXPECT_LE(taken, assumed);
    EXPECT_LE(taken, reckoned);
  }
}

TEST(PatchFootprint, BytesThatAreNoSurfaceAreWeighedAsNothing) {
  EncodedScene encoded = SceneEncoder().encode(teapots(2));
  const std::span<const std::byte> bytes = *encoded.blocks[1].bytes;
  PatchFootprint footprint;
  EXPECT_GT(footprint.bytes(encoded.blocks[1], 2, 64), 0u);
  for (const std::size_t kept : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
    const std::vector<std::byte> cut(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(kept));
    EXPECT_EQ(footprint.bytes(make_scene_block(cut), 2, 64), 0u) << kept;
  }
}

// A version of a surface whose patches are as steep as `slope` says.
SceneBlock bent_by(float slope) {
  Scene scene = mixed_patches(100);
  PatchSurface bent = *scene.surfaces[0];
  for (std::size_t i = 2; i < bent.numbers.size(); i += 3) bent.numbers[i] *= slope;
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(bent))};
  return SceneEncoder().encode(scene).blocks[1];
}

TEST(PatchFootprint, ASurfaceThatDeformsIsWeighedNowAndThen) {
  const auto weigh = [](PatchFootprint& by, const SceneBlock& block) {
    return by.bytes(block, 1, 100);
  };
  PatchFootprint fresh, followed;
  const std::uint64_t flat = weigh(followed, bent_by(0)), bent = weigh(fresh, bent_by(1));
  ASSERT_GT(bent, 2 * flat);
  for (int version = 0; version < PatchFootprint::kUsesMax; ++version) {
    const SceneBlock block = bent_by(2 + static_cast<float>(version));
    EXPECT_EQ(weigh(followed, block), flat) << version;
    EXPECT_EQ(weigh(followed, block), flat) << version << ", once more";
  }
  EXPECT_EQ(weigh(followed, bent_by(1)), bent);
}

INSTANTIATE_TEST_SUITE_P(Structures, SceneMemory,
                         testing::Values(Structure::kAuto, Structure::kBvh, Structure::kBvhQuality,
                                         Structure::kKd, Structure::kKdQuality));
// Kd-trees hold no patches.
INSTANTIATE_TEST_SUITE_P(Structures, PatchMemory,
                         testing::Values(Structure::kAuto, Structure::kBvh,
                                         Structure::kBvhQuality));

}  // namespace
}  // namespace tessera::core
