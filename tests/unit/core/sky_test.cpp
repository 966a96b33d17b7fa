// SPDX-License-Identifier: Apache-2.0
// Light from an environment map: its samples, their pdf, and the surfaces that it lights.
#include "slave/core/light/sky_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/bsdf_at.h"
#include "tests/support/packets.h"
#include "tests/support/plain_sky.h"
#include "tests/support/render.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr double kPi = 3.14159265358979;

double mean_of(const std::vector<float>& rgb) {
  double sum = 0;
  for (const float x : rgb) {
    EXPECT_TRUE(std::isfinite(x));
    sum += x;
  }
  return sum / static_cast<double>(rgb.size());
}

template <class Radiance>
std::shared_ptr<const EnvironmentMap> make_map(int width_px, int height_px, Radiance radiance) {
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = width_px;
  map->height_px = height_px;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      for (int c = 0; c < 3; ++c) map->rgb.push_back(radiance(x, y));
    }
  }
  return map;
}

// A map that is dark but for a sun and some texels beside the poles, at the seam and in between.
std::shared_ptr<const EnvironmentMap> sunny() {
  return make_map(32, 16, [](int x, int y) {
    if (x == 3 && y == 4) return 5000.0f;
    if ((x == 0 && y == 9) || (x == 31 && y == 7) || y == 0 || y == 15) return 2.0f;
    return x > 20 && x < 26 ? 0.25f : 0.0f;
  });
}

Vec3f direction_at(double column_turns, double polar) {
  return {static_cast<float>(-std::sin(polar) * std::sin(2 * kPi * column_turns)),
          static_cast<float>(std::cos(polar)),
          static_cast<float>(std::sin(polar) * std::cos(2 * kPi * column_turns))};
}

TEST(SkyMap, ColumnsAndRowsLookWhereTheySay) {
  const auto at = [](int x, int y, Vec3f direction) {
    const SkyMap sky(
        make_map(64, 32, [&](int i, int j) { return i == x && j == y ? 1.0f : 0.0f; }));
    return test::plain_radiance(sky, direction * 7).x;
  };
  EXPECT_GT(at(32, 16, {0.05f, -0.05f, -1}), 0.9f);  // the middle is -z, right of it +x
  EXPECT_GT(at(48, 16, {1, -0.05f, 0.05f}), 0.9f);
  EXPECT_GT(at(16, 16, {-1, -0.05f, -0.05f}), 0.9f);
  EXPECT_GT(at(63, 15, {0.05f, 0.05f, 1}), 0.9f);
  EXPECT_GT(at(0, 15, {-0.05f, 0.05f, 1}), 0.9f);
  const SkyMap up(make_map(8, 4, [](int, int y) { return y == 0 ? 1.0f : 0.0f; }));
  EXPECT_EQ(test::plain_radiance(up, {0, 1, 0}).x, 1.0f);
  EXPECT_EQ(test::plain_radiance(up, {0, -1, 0}).x, 0.0f);
}

TEST(SkyMap, SamplesAreOfThePdfThatItNames) {
  const SkyMap sky(sunny());
  double covered = 0;
  int off = 0;
  constexpr std::uint32_t kCount = 1u << 16;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const SkyMap::Sample s = sky.sample(sample_2d(3, i));
    ASSERT_NEAR(length(s.direction), 1, 1e-6);
    covered += s.angle / kCount;
    // At the edge of a texel a rounding decides on which side a direction is; neither pdf is wrong.
    off += std::fabs(test::plain_pdf(sky, s.direction) * s.angle - 1) > 1e-3f ? 1 : 0;
    // Radiance is bilinear between texels of 0 and 5000, and directions are rounded.
    const float slope = 1e-3f * (1 + 5000);
    ASSERT_NEAR(test::plain_radiance(sky, s.direction).x, s.radiance.x, slope);
  }
  EXPECT_LT(off, kCount / 1000);
  EXPECT_NEAR(covered, 4 * kPi, 0.01 * 4 * kPi);  // the sphere, each sample by its angle
}

// The integral of the samples is that of the midpoint rule, in double.
TEST(SkyMap, SamplesSumToTheIntegral) {
  for (const auto& map :
       {sunny(), make_map(7, 3, [](int x, int y) { return 1.0f + static_cast<float>(x * y); }),
        make_map(1, 1, [](int, int) { return 2.0f; })}) {
    const SkyMap sky(map);
    const auto weight = [](Vec3f d) { return 1 + d.x + 2 * d.y * d.y + d.z * d.y; };
    double expected = 0;
    constexpr int kRows = 1500;
    for (int j = 0; j < kRows; ++j) {
      const double polar = (j + 0.5) / kRows * kPi;
      for (int i = 0; i < 2 * kRows; ++i) {
        const Vec3f d = direction_at((i + 0.5) / (2 * kRows), polar);
        expected += test::plain_radiance(sky, d).x * weight(d) * std::sin(polar);
      }
    }
    expected *= kPi / kRows * kPi / kRows;
    double sum = 0;
    constexpr std::uint32_t kCount = 1u << 16;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const SkyMap::Sample s = sky.sample(sample_2d(5, i));
      sum += s.radiance.x * s.angle * weight(s.direction) / kCount;
    }
    EXPECT_NEAR(sum, expected, 2e-3 * expected) << map->width_px;
  }
}

TEST(SkyMap, NoDirectionThatShedsLightHasADensityOfZero) {
  const SkyMap sky(sunny());
  std::mt19937 random(test::seed(4));
  std::normal_distribution<float> normal;
  for (int i = 0; i < 1000000; ++i) {
    const Vec3f d = normalize({normal(random), normal(random), normal(random)});
    ASSERT_FALSE(test::plain_radiance(sky, d).x > 1e-4f && !(test::plain_pdf(sky, d) > 0))
        << d.x << " " << d.y << " " << d.z;
  }
}

TEST(SkyMap, AxesPolesAndTheSeamHaveLightAndNoSurprises) {
  const SkyMap sky(sunny());
  const float tiny = 1e-30f;
  for (const Vec3f d : {Vec3f{0, 1, 0},
                        {0, -1, 0},
                        {0, 0, 1},
                        {0, 0, -1},
                        {1, 0, 0},
                        {-1, 0, 0},
                        {0, 0, 0},
                        {tiny, 1, tiny},
                        {-tiny, 0, 1},
                        {tiny, 0, 1},
                        {-0.0f, -0.0f, 1}}) {
    EXPECT_TRUE(std::isfinite(test::plain_radiance(sky, d).x));
    EXPECT_TRUE(std::isfinite(test::plain_pdf(sky, d)));
  }
  for (const float x : {0.0f, 1 - 0x1p-24f}) {
    for (const float y : {0.0f, 1 - 0x1p-24f}) {
      const SkyMap::Sample s = sky.sample({x, y});
      EXPECT_TRUE(std::isfinite(s.angle) && is_finite(s.direction) && is_finite(s.radiance));
    }
  }
}

FrameSettings settings_of(Renderer renderer, int size_px, int samples) {
  FrameSettings settings;
  settings.width_px = settings.height_px = size_px;
  settings.camera = {{0, 2, 0}, {0, 0, 0}, {0, 0, 1}, 20};
  settings.renderer = renderer;
  settings.samples_per_pixel = samples;
  settings.light_samples = 4;
  settings.bounces = 0;
  return settings;
}

constexpr Renderer kRenderers[] = {Renderer::kPath, Renderer::kDirect, Renderer::kIgi};

// A floor lies under a sky that is brighter to one side; the midpoint rule has its irradiance.
TEST(SkyLight, AFloorHasTheIrradianceOfItsHemisphere) {
  Mesh mesh;
  mesh.materials.clear();
  test::add_quad(mesh, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 0);
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
  scene.environment = {2, 2, 2};
  scene.environment_map = sunny();
  const SkyMap sky(scene.environment_map);
  double expected = 0;
  constexpr int kRows = 1500;
  for (int j = 0; j < kRows / 2; ++j) {
    const double polar = (j + 0.5) / kRows * kPi;
    for (int i = 0; i < 2 * kRows; ++i)
      expected += test::plain_radiance(sky, direction_at((i + 0.5) / (2 * kRows), polar)).x *
                  std::cos(polar) * std::sin(polar);
  }
  expected *= 2 * 0.5 / kPi * (kPi / kRows) * (kPi / kRows);
  for (const Renderer renderer : kRenderers) {
    FrameSettings settings = settings_of(renderer, 32, 64);
    settings.vpls = 1024;
    EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, 0.005 * expected)
        << renderer_name(renderer);
  }
}

// A map that is the same everywhere is the even sky, for every kind of surface.
TEST(SkyLight, AnEvenMapIsTheEvenSky) {
  Scene scene = test::make_scene(test::make_icosphere(4));
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.environment = {0.5f, 0.5f, 0.5f};
  for (const BsdfKind bsdf : {BsdfKind::kDiffuse, BsdfKind::kGlossy, BsdfKind::kMirror}) {
    scene.materials[0].bsdf = bsdf;
    scene.materials[0].roughness = 0.4f;
    for (const Renderer renderer : kRenderers) {
      FrameSettings settings = settings_of(renderer, 48, 16);
      settings.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 50};
      scene.environment_map = nullptr;
      const double even = mean_of(test::render(scene, settings));
      scene.environment_map = make_map(16, 8, [](int, int) { return 1.0f; });
      EXPECT_NEAR(mean_of(test::render(scene, settings)), even, 0.005 * even)
          << renderer_name(renderer) << " " << static_cast<int>(bsdf);
    }
  }
}

// Light samples and BSDF samples share a sun by MIS weights. Their sum is the integral of BSDF
// times sky, here by the midpoint rule.
TEST(SkyLight, GlossySurfacesCountASunOnce) {
  Mesh mesh;
  mesh.materials.clear();
  test::add_quad(mesh, {-9, 0, 9}, {18, 0, 0}, {0, 0, -18}, 0);
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials[0].bsdf = BsdfKind::kGlossy;
  scene.materials[0].metalness = 1;
  scene.materials[0].albedo = {1, 1, 1};
  scene.environment = {1, 1, 1};
  scene.environment_map =
      make_map(32, 16, [](int x, int y) { return x == 8 && y == 4 ? 40.0f : 0.5f; });
  const SkyMap sky(scene.environment_map);
  const Vec3f to_eye = normalize({1, 1, 0});
  for (const float roughness : {0.3f, 0.5f, 1.0f}) {
    scene.materials[0].roughness = roughness;
    Surface s;
    s.normal = s.shading_normal = {0, 1, 0};
    s.bsdf = BsdfKind::kGlossy;
    s.albedo = {1, 1, 1};
    s.roughness = roughness;
    s.metalness = 1;
    s.material = &scene.materials[0];
    double expected = 0;
    constexpr int kRows = 1000;
    for (int j = 0; j < kRows / 2; ++j) {
      const double polar = (j + 0.5) / kRows * kPi;
      for (int i = 0; i < 2 * kRows; ++i) {
        const Vec3f d = direction_at((i + 0.5) / (2 * kRows), polar);
        expected += test::evaluate(s, to_eye, d).times_pi.x * test::plain_radiance(sky, d).x *
                    std::cos(polar) * std::sin(polar);
      }
    }
    expected *= kPi / (double{kRows} * kRows);
    for (const Renderer renderer : kRenderers) {
      FrameSettings settings = settings_of(renderer, 64, 64);
      settings.camera = {to_eye, {0, 0, 0}, {0, 0, 1}, 0.01f};
      EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, 0.01 * expected)
          << renderer_name(renderer) << " " << roughness;
    }
  }
}

// The rest of the sky lights surfaces that a sun does not reach, however dim it is beside the sun.
TEST(SkyLight, SurfacesTurnedFromTheSunKeepTheirLight) {
  Mesh mesh;
  mesh.materials.clear();
  test::add_quad(mesh, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 0);
  Scene scene = test::make_scene(std::move(mesh));
  scene.environment = {1, 1, 1};
  const double expected = double{scene.materials[0].albedo.x};  // under an even sky
  for (const float sun : {1e5f, 1e11f}) {
    scene.environment_map =
        make_map(64, 32, [&](int x, int y) { return x == 20 && y == 28 ? sun : 1.0f; });
    for (const Renderer renderer : kRenderers) {
      FrameSettings settings = settings_of(renderer, 16, 64);
      settings.vpls = 1024;
      EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, 0.03 * expected)
          << renderer_name(renderer) << " " << sun;
    }
  }
}

// The scene has surfaces in each other's shadow, light over several of them, and a sun.
TEST(SkyLight, IgiHasTheMeanOfThePathTracer) {
  Scene scene = test::make_full_scene();
  scene.environment = {1, 1, 1};
  scene.environment_map = sunny();
  FrameSettings settings = settings_of(Renderer::kIgi, 48, 16);
  settings.camera = {{0.3f, 1.4f, 2.5f}, {0, 0.1f, 0}, {0, 1, 0}, 50};
  settings.bounces = 2;
  settings.vpls = 256;
  double igi = 0;
  for (settings.seed = 0; settings.seed < 8; ++settings.seed)
    igi += mean_of(test::render(scene, settings)) / 8;
  settings.renderer = Renderer::kPath;
  settings.samples_per_pixel = 256;
  const double path = mean_of(test::render(scene, settings));
  EXPECT_NEAR(igi, path, 0.01 * path);
}

TEST(SkyLight, BitsDoNotDependOnTilesOrInstructionSet) {
  Scene scene = test::make_scene_of_all_materials();
  scene.environment = {1, 1, 1};
  scene.environment_map = sunny();
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  for (const Renderer renderer : kRenderers) {
    FrameSettings settings = settings_of(renderer, 70, 2);
    settings.camera = {{0.3f, 1.4f, 2.5f}, {0, 0.1f, 0}, {0, 1, 0}, 50};
    settings.bounces = 2;
    settings.vpls = 12;
    const std::vector<float> whole = test::render_in_tiles(**prepared, settings, Isa::kScalar, 256);
    for (const Isa isa : test::isas_here()) {
      EXPECT_TRUE(test::same_bits(whole, test::render_in_tiles(**prepared, settings, isa, 33)))
          << isa_name(isa) << " " << renderer_name(renderer);
    }
  }
}

TEST(SkyLight, ABlackMapIsNoLight) {
  Scene scene = test::make_full_scene();
  scene.lights.clear();
  for (Material& m : scene.materials) m.emission = {};
  scene.environment = {1, 1, 1};
  scene.environment_map = make_map(4, 2, [](int, int) { return 0.0f; });
  Scene without = scene;
  without.environment = {};
  without.environment_map = nullptr;
  const FrameSettings settings = settings_of(Renderer::kPath, 16, 1);
  EXPECT_EQ(test::render(scene, settings), test::render(without, settings));
}

}  // namespace
}  // namespace tessera::core
