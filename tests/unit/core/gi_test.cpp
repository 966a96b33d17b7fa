// SPDX-License-Identifier: Apache-2.0
// Instant global illumination: its bits, its mean against other methods, its filter and its clamp.
#include <gtest/gtest.h>

#include <cmath>

#include "common/frame/tile_border.h"
#include "slave/core/integrate/igi/gi_tile.h"
#include "slave/core/integrate/igi/vpl_set.h"
#include "slave/core/kernels/kernel_table.h"
#include "tests/support/packets.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

FrameSettings gi_settings(int width_px, int height_px) {
  FrameSettings settings;
  settings.width_px = width_px;
  settings.height_px = height_px;
  settings.camera = {{0.3f, 1.4f, 2.5f}, {0, 0.1f, 0}, {0, 1, 0}, 50};
  settings.renderer = Renderer::kIgi;
  settings.bounces = 2;
  return settings;
}

double mean_of(const std::vector<float>& rgb) {
  double sum = 0;
  for (const float x : rgb) {
    EXPECT_TRUE(std::isfinite(x));
    EXPECT_GE(x, 0.0f);
    sum += x;
  }
  return sum / static_cast<double>(rgb.size());
}

// Mean of pictures of several seeds, which have independent sets of VPLs.
double mean_over_seeds(const Scene& scene, FrameSettings settings, std::uint32_t seeds) {
  double sum = 0;
  for (settings.seed = 0; settings.seed < seeds; ++settings.seed)
    sum += mean_of(test::render(scene, settings));
  return sum / seeds;
}

VplSets vpls_of(const Scene& scene, const FrameSettings& settings) {
  const auto prepared = PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  const PreparedScene::Impl& impl = (*prepared)->impl();
  return VplSets(impl, SceneTracer(impl.index, kernels_for(widest_isa(supported_isas()))),
                 settings);
}

TEST(GlobalIllumination, BitsDoNotDependOnTilesOrInstructionSet) {
  const Scene scenes[] = {test::make_full_scene(), test::make_scene_of_all_materials()};
  for (const Scene& of : scenes) {
    const auto scene = PreparedScene::build(of, {});
    ASSERT_TRUE(scene.is_ok());
    for (const int interleave : {1, 3, 5}) {
      FrameSettings settings = gi_settings(90, 70);
      settings.vpls = 12;
      settings.interleave = interleave;
      settings.samples_per_pixel = interleave == 3 ? 3 : 1;
      settings.clamp = interleave == 3 ? 0.5f : 0;
      settings.is_compensated = interleave == 3;
      settings.pass = interleave == 5 ? kFilteredPasses : 0;
      const std::vector<float> whole = test::render_in_tiles(**scene, settings, Isa::kScalar, 256);
      EXPECT_GT(mean_of(whole), 0.01);
      for (const Isa isa : test::isas_here()) {
        for (const int edge_px : {256, interleave == 3 ? 7 : 33}) {
          EXPECT_TRUE(
              test::same_bits(whole, test::render_in_tiles(**scene, settings, isa, edge_px)))
              << isa_name(isa) << " tile " << edge_px << " interleave " << interleave;
        }
      }
    }
  }
}

// Instant global illumination cannot carry caustics of mirrors and glass. Without these, its mean
// is that of the path tracer.
TEST(GlobalIllumination, GlossySurfacesHaveTheMeanOfThePathTracer) {
  Scene scene = test::make_full_scene();
  scene.materials[1].bsdf = BsdfKind::kGlossy;
  scene.materials[1].roughness = 0.3f;
  scene.materials[1].metalness = 0.5f;
  FrameSettings settings = gi_settings(48, 36);
  settings.samples_per_pixel = 16;
  const double igi = mean_over_seeds(scene, settings, 8);
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 256;
  const double path = mean_of(test::render(scene, settings));
  EXPECT_NEAR(igi, path, 0.01 * path);
}

// The scene has every kind of light and light over several surfaces.
TEST(GlobalIllumination, HasTheMeanOfThePathTracer) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(48, 36);
  settings.samples_per_pixel = 16;
  settings.vpls = 256;
  const double igi = mean_over_seeds(scene, settings, 16);
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 256;
  const double path = mean_of(test::render(scene, settings));
  EXPECT_NEAR(igi, path, 0.01 * path);
}

TEST(GlobalIllumination, SplittingTheSetOverSamplesKeepsTheMean) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(48, 36);
  settings.vpls = 64;
  double means[2];
  for (int i = 0; i < 2; ++i) {
    settings.samples_per_pixel = i == 0 ? 16 : 4;
    means[i] = mean_over_seeds(scene, settings, 16);
  }
  EXPECT_NEAR(means[0], means[1], 0.01 * means[1]);
}

// Everything emits 1 and reflects a, so that 1 + a + ... + a^k is seen after k surfaces. A sphere
// that is seen from its middle has no corners, and no VPLs are close by but for those on its walls.
TEST(GlobalIllumination, FurnaceIsTheGeometricSeries) {
  Mesh mesh = test::make_icosphere(3);
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // emission goes inwards
  Scene scene = test::make_scene(std::move(mesh));
  const float albedo = 0.5f;
  scene.materials[0].albedo = {albedo, albedo, albedo};
  scene.materials[0].emission = {1, 1, 1};
  FrameSettings settings = gi_settings(64, 64);
  settings.camera = {{0, 0, 0}, {1, 0.2f, 0.3f}, {0, 1, 0}, 90};
  settings.vpls = 256;
  for (const int bounces : {0, 2}) {
    settings.bounces = bounces;
    double expected = 0;
    for (int k = 0; k <= bounces + 1; ++k) expected += std::pow(albedo, k);
    EXPECT_NEAR(mean_over_seeds(scene, settings, 8), expected, 0.01 * expected) << bounces;
  }
}

// The irradiance of a point under the middle of a square of side a, height h and radiance L is
// 4 L (k / sqrt(1 + k^2)) atan(k / sqrt(1 + k^2)) with k = a / (2 h).
TEST(GlobalIllumination, FloorUnderASquareLightHasTheClosedForm) {
  Mesh mesh;
  mesh.positions = {{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}, {-9, 0, 9},
                    {-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  mesh.materials = {0, 0, 1, 1};
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
  scene.materials[1].name = "lamp";
  scene.materials[1].albedo = {0, 0, 0};
  scene.materials[1].emission = {3, 3, 3};
  FrameSettings settings = gi_settings(9, 9);
  settings.camera = {{0, 0.5f, 0}, {0, 0, 0}, {0, 0, 1}, 2};
  settings.bounces = 0;
  settings.vpls = 1024;
  const double k = 1, s = k / std::sqrt(1 + k * k);
  const double expected = 0.5 / 3.14159265358979 * 4 * 3 * s * std::atan(s);
  EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, 0.002 * expected);
}

TEST(GlobalIllumination, FilterKeepsTheMeanAndCalmsThePicture) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(96, 72);
  const std::vector<float> filtered = test::render(scene, settings);
  settings.is_filtered = false;
  const std::vector<float> raw = test::render(scene, settings);
  EXPECT_NEAR(mean_of(filtered), mean_of(raw), 0.01 * mean_of(raw));
  const auto roughness = [](const std::vector<float>& rgb) {
    double sum = 0;
    for (std::size_t i = 3; i < rgb.size(); i += 3) sum += std::fabs(rgb[i] - rgb[i - 3]);
    return sum;
  };
  EXPECT_LT(roughness(filtered), 0.8 * roughness(raw));
}

// The filter's error, where light changes from pixel to pixel, stays in the mean of passes while
// they are filtered and goes when they are not. The scene is a thin rod that is lit from one side.
TEST(GlobalIllumination, PassesComeToTheTruthWhatTheFilterDoes) {
  Mesh mesh;
  constexpr int kAround = 64;
  for (int i = 0; i <= kAround; ++i) {
    const float turn = 6.2831853f * static_cast<float>(i) / kAround;
    for (const float y : {-1.0f, 1.0f}) {
      mesh.positions.push_back({0.03f * std::cos(turn), y, 0.03f * std::sin(turn)});
      mesh.normals.push_back({std::cos(turn), 0, std::sin(turn)});
    }
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    mesh.triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  mesh.materials = {0};
  Scene scene = test::make_scene(std::move(mesh));
  scene.lights.push_back({LightKind::kDirectional, {}, {-1, 0, -0.3f}, {3, 3, 3}, 1, 0});
  FrameSettings settings = gi_settings(24, 24);
  settings.camera = {{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 4};
  const auto off_by = [&](std::uint32_t pass) {
    settings.pass = pass;
    settings.is_filtered = true;
    const std::vector<float> filtered = test::render(scene, settings);
    settings.is_filtered = false;
    const std::vector<float> truth = test::render(scene, settings);
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += std::fabs(filtered[i] - truth[i]);
    return sum / static_cast<double>(truth.size()) / mean_of(truth);
  };
  EXPECT_GT(off_by(kFilteredPasses - 1), 0.01);
  EXPECT_EQ(off_by(kFilteredPasses), 0);
}

// Two walls of different material stand side by side in one plane, and one of them is black.
// Nothing of the light of one is seen on the other, and both keep their edge.
TEST(GlobalIllumination, FilterStopsAtMaterialsAndCorners) {
  Mesh mesh;
  mesh.positions = {{-4, -4, 0}, {0, -4, 0}, {0, 4, 0}, {-4, 4, 0}, {4, -4, 0}, {4, 4, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  mesh.materials = {0, 0, 1, 1};
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[0].albedo = {0.8f, 0.8f, 0.8f};
  scene.materials[1].albedo = {0, 0, 0};
  scene.lights.push_back({LightKind::kPoint, {0, 0, 2}, {}, {9, 9, 9}, 1, 0});
  FrameSettings settings = gi_settings(32, 32);
  settings.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 40};
  const std::vector<float> rgb = test::render(scene, settings);
  for (std::size_t y = 0; y < 32; ++y) {
    for (std::size_t x = 0; x < 32; ++x) {
      EXPECT_EQ(x<16, rgb[3 * (32 * y + x)]> 0.1f) << x << " " << y;
      EXPECT_EQ(x >= 16, rgb[3 * (32 * y + x)] == 0.0f) << x << " " << y;
    }
  }
}

TEST(GlobalIllumination, HundredsOfLightsCostNoMoreThanTheirVpls) {
  Scene scene = test::make_scene(test::make_terrain(20, 2));
  for (int i = 0; i < 400; ++i) {
    const auto x = static_cast<float>(i % 20), z = static_cast<float>(i / 20);
    scene.lights.push_back({LightKind::kPoint, {x / 10 - 1, 1, z / 10 - 1}, {}, {1, 1, 1}, 1, 0});
  }
  FrameSettings settings = gi_settings(32, 32);
  settings.vpls = 32;
  const VplSets vpls = vpls_of(scene, settings);
  EXPECT_TRUE(vpls.each().empty());
  for (int k = 0; k < 9; ++k) EXPECT_LE(vpls.set(k).size(), 32u);
  // The light of all 400 is there, over the sets.
  const double igi = mean_over_seeds(scene, settings, 16);
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 64;
  const double path = mean_of(test::render(scene, settings));
  EXPECT_NEAR(igi, path, 0.02 * path);
}

TEST(GlobalIllumination, ClampingTakesLightAwayAndNeverAddsAny) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(48, 36);
  const std::vector<float> all = test::render(scene, settings);
  settings.clamp = 0.5f;
  const std::vector<float> clamped = test::render(scene, settings);
  EXPECT_LT(mean_of(clamped), mean_of(all));
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_LE(clamped[i], all[i] * (1 + 1e-5f));
}

// Under a low clamp, bias compensation brings back all the light that the clamp takes away.
TEST(GlobalIllumination, CompensationBringsBackWhatClampingTakes) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(48, 36);
  settings.samples_per_pixel = 16;
  settings.clamp = 0.2f;
  settings.is_compensated = true;
  const double compensated = mean_over_seeds(scene, settings, 8);
  settings.is_compensated = false;
  const double clamped = mean_over_seeds(scene, settings, 8);
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 256;
  const double path = mean_of(test::render(scene, settings));
  EXPECT_LT(clamped, 0.97 * path);
  EXPECT_NEAR(compensated, path, 0.005 * path);
}

TEST(GlobalIllumination, SeedAndPassMakeOtherVpls) {
  const Scene scene = test::make_full_scene();
  FrameSettings settings = gi_settings(32, 24);
  const std::vector<float> first = test::render(scene, settings);
  EXPECT_TRUE(test::same_bits(first, test::render(scene, settings)));
  settings.seed = 1;
  EXPECT_FALSE(test::same_bits(first, test::render(scene, settings)));
  settings.seed = 0;
  settings.pass = 1;
  EXPECT_FALSE(test::same_bits(first, test::render(scene, settings)));
}

}  // namespace
}  // namespace tessera::core
