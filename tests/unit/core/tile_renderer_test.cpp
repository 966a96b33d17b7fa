// SPDX-License-Identifier: Apache-2.0
// A pixel depends on settings, scene, instruction set, its place and the sample index; on nothing
// else.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <thread>

#include "common/base/limits.h"
#include "tests/support/asleep.h"
#include "tests/support/packets.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

FrameSettings settings_of(Renderer renderer, int samples) {
  FrameSettings settings;
  settings.width_px = 83;
  settings.height_px = 61;
  settings.camera = {{0.3f, 1.4f, 2.5f}, {0, 0.1f, 0}, {0, 1, 0}, 50};
  settings.renderer = renderer;
  settings.samples_per_pixel = samples;
  settings.seed = 5;
  return settings;
}

TEST(TileRenderer, BitsOfAFrameDoNotDependOnTheTilesOrTheInstructionSet) {
  const auto scene = PreparedScene::build(test::make_full_scene(), {});
  ASSERT_TRUE(scene.is_ok());
  for (const FrameSettings& settings :
       {settings_of(Renderer::kPrimary, 1), settings_of(Renderer::kDirect, 1),
        settings_of(Renderer::kDirect, 3), settings_of(Renderer::kPath, 2)}) {
    RayCounts whole_counts;
    const std::vector<float> whole =
        test::render_in_tiles(**scene, settings, Isa::kScalar, 256, &whole_counts);
    double sum = 0;
    for (const float x : whole) {
      ASSERT_TRUE(std::isfinite(x));
      ASSERT_GE(x, 0.0f);
      sum += x;
    }
    EXPECT_GT(sum, 100);
    for (const Isa isa : test::isas_here()) {
      for (const int edge_px : {16, 32, 40, 5, 7}) {
        RayCounts counts;
        EXPECT_TRUE(
            test::same_bits(whole, test::render_in_tiles(**scene, settings, isa, edge_px, &counts)))
            << isa_name(isa) << " tile " << edge_px;
        EXPECT_TRUE(counts == whole_counts);
      }
    }
    EXPECT_EQ(83u * 61u * static_cast<unsigned>(settings.samples_per_pixel), whole_counts.primary);
    EXPECT_EQ(settings.renderer != Renderer::kPrimary, whole_counts.shadow > 0);
    EXPECT_EQ(settings.renderer == Renderer::kPath, whole_counts.secondary > 0);
  }
}

TEST(TileRenderer, BitsDoNotDependOnTilesOrInstructionSetWithAnyMaterial) {
  const auto scene = PreparedScene::build(test::make_scene_of_all_materials(), {});
  ASSERT_TRUE(scene.is_ok());
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath}) {
    const FrameSettings settings = settings_of(renderer, 2);
    RayCounts whole_counts;
    const std::vector<float> whole =
        test::render_in_tiles(**scene, settings, Isa::kScalar, 256, &whole_counts);
    for (const float x : whole) ASSERT_TRUE(std::isfinite(x) && x >= 0);
    EXPECT_GT(whole_counts.secondary, 100u);
    for (const Isa isa : test::isas_here()) {
      for (const int edge_px : {32, 7}) {
        RayCounts counts;
        EXPECT_TRUE(
            test::same_bits(whole, test::render_in_tiles(**scene, settings, isa, edge_px, &counts)))
            << isa_name(isa) << " tile " << edge_px;
        EXPECT_TRUE(counts == whole_counts);
      }
    }
  }
}

TEST(TileRenderer, SeedMovesSamplesAndOnlyThen) {
  const auto scene = PreparedScene::build(test::make_full_scene(), {});
  ASSERT_TRUE(scene.is_ok());
  FrameSettings settings = settings_of(Renderer::kDirect, 4);
  const std::vector<float> a = test::render_in_tiles(**scene, settings, Isa::kScalar, 32);
  settings.seed = 6;
  EXPECT_FALSE(test::same_bits(a, test::render_in_tiles(**scene, settings, Isa::kScalar, 32)));
  settings = settings_of(Renderer::kPrimary, 1);
  const std::vector<float> b = test::render_in_tiles(**scene, settings, Isa::kScalar, 32);
  settings.seed = 6;
  EXPECT_TRUE(test::same_bits(b, test::render_in_tiles(**scene, settings, Isa::kScalar, 32)));
}

TEST(TileRenderer, PrimaryIsTheDistanceAlongTheNormalisedRay) {
  Mesh wall;
  wall.positions = {{-50, -50, -3}, {50, -50, -3}, {0, 90, -3}};
  wall.triangles = {{0, 1, 2}};
  wall.materials = {0};
  const auto scene = PreparedScene::build(test::make_scene(wall), {});
  ASSERT_TRUE(scene.is_ok());
  FrameSettings settings;
  settings.width_px = 40;
  settings.height_px = 30;
  settings.camera = {{0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90};
  settings.renderer = Renderer::kPrimary;
  const std::vector<float> image = test::render_in_tiles(**scene, settings, Isa::kScalar, 16);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double dx = (x + 0.5 - 20) / 15, dy = (15 - y - 0.5) / 15;
      const float got = image[3 * static_cast<std::size_t>(y * 40 + x)];
      const double secant = std::sqrt(1 + dx * dx + dy * dy);
      // The project's tolerance is 16 u s / cos, and the farthest vertex is s = 94.1 away.
      EXPECT_NEAR(4 * secant, got, 16 * 0x1p-24 * 94.1 * secant) << x << " " << y;
    }
  }
}

TEST(TileRenderer, ATileIsLeftInItsMiddleWhenItsFrameIsCancelled) {
  const auto scene = PreparedScene::build(test::make_full_scene(), {});
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.camera = {{0, 2, 4}, {0, 0.5f, 0}, {0, 1, 0}, 50};
  settings.samples_per_pixel = kSamplesPerPixelMax;
  settings.light_samples = kLightSamplesMax;
  // The whole tile takes many seconds of this thread's processor time. It is cancelled after a
  // share of them, so that other load of the machine does not matter. If the tile had not begun, or
  // had ended, the share was wrong and another one is tried. A renderer that does not check for
  // cancellation within the tile never leaves it in its middle.
  constexpr std::uint64_t kAll = 32u * 32u * kSamplesPerPixelMax;
  std::uint64_t primary = 0;
  const test::ProcessorClock work(pthread_self());
  double share_s = 0.03;
  for (int attempt = 0; attempt < 5 && (primary == 0 || primary == kAll); ++attempt) {
    std::atomic<bool> is_cancelled{false}, has_ended{false};
    const double end_s = work.seconds() + share_s;
    std::thread canceller([&] {
      while (work.seconds() < end_s && !has_ended) std::this_thread::yield();
      is_cancelled = true;
    });
    std::vector<float> rgb(3 * 32 * 32);
    primary = TileRenderer()
                  .render(**scene, settings, Isa::kScalar, {0, 0, 32, 32}, rgb, &is_cancelled)
                  .primary;
    has_ended = true;
    canceller.join();
    share_s = primary == 0 ? 4 * share_s : share_s / 4;
  }
  EXPECT_GT(primary, 0u);
  EXPECT_LT(primary, kAll);
}

TEST(TileRenderer, EmptySceneIsBlackAndCancelStops) {
  Scene empty;
  empty.materials.emplace_back();
  const auto scene = PreparedScene::build(empty, {});
  ASSERT_TRUE(scene.is_ok());
  for (const float x :
       test::render_in_tiles(**scene, settings_of(Renderer::kDirect, 1), Isa::kScalar, 32)) {
    ASSERT_EQ(0.0f, x);
  }
  const std::atomic<bool> is_cancelled{true};
  std::vector<float> rgb(3 * 16 * 16);
  TileRenderer renderer;
  const RayCounts counts = renderer.render(**scene, settings_of(Renderer::kDirect, 1), Isa::kScalar,
                                           {0, 0, 16, 16}, rgb, &is_cancelled);
  EXPECT_EQ(0u, counts.primary);
}

TEST(TileRenderer, WithoutLightAMeshIsDarkBeforeItsBackground) {
  Scene dark = test::make_scene(test::make_icosphere(3));
  dark.background = {BackgroundKind::kGradient, {0, 1, 0}, {2, 1, 0}};
  const auto scene = PreparedScene::build(dark, {});
  ASSERT_TRUE(scene.is_ok());
  FrameSettings settings = settings_of(Renderer::kDirect, 1);
  settings.width_px = settings.height_px = 33;
  settings.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 40};
  const std::vector<float> image = test::render_in_tiles(**scene, settings, Isa::kScalar, 16);
  EXPECT_EQ(0.0f, image[3 * (16 * 33 + 16)]);
  // The upper left pixel looks 32/33 of tan(20 degrees) up and as much aside; the square root
  // normalises its direction.
  const float aside = std::tan(20 * 3.14159265f / 180) * 32 / 33;
  const float up = 0.5f + aside / std::sqrt(1 + 2 * aside * aside);
  EXPECT_NEAR(image[0], 2 * up, 1e-3f);
  EXPECT_EQ(image[1], 1);
  EXPECT_NEAR(image[3 * (33 * 32)], 2 * (1 - up), 1e-3f);
}

}  // namespace
}  // namespace tessera::core
