// SPDX-License-Identifier: Apache-2.0
// Property: light that patches scatter, emit and let through is that of closed forms, textures lie
// along their parameters, and pictures of them are the same on every instruction set.
#include <gtest/gtest.h>

#include <cmath>

#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/render.h"
#include "tests/support/surface_at.h"

namespace tessera::core {
namespace {

FrameSettings settings_of(Renderer renderer, int bounces, int samples) {
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.renderer = renderer;
  settings.bounces = bounces;
  settings.samples_per_pixel = samples;
  settings.camera = {{0, 0.2f, 0.1f}, {0, -1, 0}, {0, 0, 1}, 60};
  return settings;
}

double mean_of(const std::vector<float>& rgb) {
  double sum = 0;
  for (const float x : rgb) sum += double{x};
  return sum / static_cast<double>(rgb.size());
}

// A convex body under an even sky reflects its albedo in every sample: it hides no sky from itself.
TEST(PatchScenes, ConvexBodyUnderAnEvenSkyReflectsItsAlbedo) {
  Scene scene = test::patch_scene_of("sphere");
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.environment = {1, 1, 1};
  for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
    FrameSettings settings = settings_of(renderer, 3, 4);
    settings.camera = {{0, 0, 1.8f}, {0, 0, 0}, {0, 1, 0}, 30};  // sees nothing but the body
    for (const float x : test::render(scene, settings)) ASSERT_NEAR(x, 0.7f, 1e-6f);
  }
}

// Everything emits 1 and reflects a: 1 + a + ... + a^k is seen after k surfaces.
TEST(PatchScenes, FurnaceIsTheGeometricSeries) {
  for (const char* shape : {"sphere", "torus", "cylinder", "cone"}) {
    SCOPED_TRACE(shape);
    Scene scene = test::patch_scene_of(shape);
    scene.materials[0].albedo = {0.8f, 0.8f, 0.8f};
    scene.materials[0].emission = {1, 1, 1};
    scene.materials[0].is_double_sided = true;
    FrameSettings settings = settings_of(Renderer::kPath, 4, 16);
    if (shape == std::string("torus")) settings.camera = {{1, 0, 0}, {1, 1, 0}, {0, 0, 1}, 60};
    double expected = 0;
    for (int k = 0; k <= 5; ++k) expected += std::pow(0.8, k);
    EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, 0.005 * expected);
  }
}

// A lamp of intensity I in the middle of a sphere gives the radiance a / pi I (1 + a + ...).
TEST(PatchScenes, SphereWithALampInItsMiddleIsTheClosedForm) {
  Scene scene = test::patch_scene_of("sphere");
  scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
  scene.lights.push_back({LightKind::kPoint, {0, 0, 0}, {}, {2, 2, 2}, 1, 0});
  for (const int bounces : {0, 3}) {
    double series = 0;
    for (int k = 0; k <= bounces; ++k) series += std::pow(0.5, k);
    const double expected = 0.5 / 3.14159265 * 2 * series;
    const auto picture = test::render(scene, settings_of(Renderer::kPath, bounces, 16));
    EXPECT_NEAR(mean_of(picture), expected, 2e-3 * expected) << bounces;
  }
}

// A sphere of radiance L and radius r, seen from the distance d to its middle, gives a surface that
// faces it the irradiance pi L (r / d)^2.
TEST(PatchScenes, SphereThatEmitsIsTheClosedForm) {
  for (const bool has_texture : {false, true}) {
    Scene scene = test::patch_scene_of("sphere");
    scene.materials.resize(2);
    scene.materials[0].albedo = {0, 0, 0};
    scene.materials[0].emission = {3, 3, 3};
    if (has_texture) {  // half of its strips along u are black
      auto texture = std::make_shared<Texture>();
      texture->width_px = 2;
      texture->height_px = 1;
      texture->is_srgb = false;
      texture->is_nearest = true;
      texture->rgba = {255, 255, 255, 255, 0, 0, 0, 255};
      scene.textures = {texture};
      scene.materials[0].emission_texture = TextureRef(0);
    }
    Mesh floor;
    floor.positions = {{-1, -1, -3}, {1, -1, -3}, {1, 1, -3}, {-1, 1, -3}};
    floor.triangles = {{0, 1, 2}, {0, 2, 3}};
    floor.materials = {1};
    scene.materials[1].albedo = {0.5f, 0.5f, 0.5f};
    scene.meshes = {std::make_shared<const Mesh>(floor)};
    scene.instances.push_back({0, {}});
    const double expected = 0.5 * 3 / 9 * (has_texture ? 0.5 : 1);
    for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
      FrameSettings settings = settings_of(renderer, 1, 64);
      settings.vpls = 1024;
      settings.camera = {{0.3f, 0, -2.5f}, {0, 0, -3}, {0, 0, 1}, 2};
      // VPLs are shared by all pixels, so that their noise is the picture's.
      const double tolerance = renderer == Renderer::kIgi ? 0.03 : 0.01;
      EXPECT_NEAR(mean_of(test::render(scene, settings)), expected, tolerance * expected)
          << renderer_name(renderer) << " " << has_texture;
    }
  }
}

// A body of opacity a that emits nothing and reflects nothing lets (1 - a)^2 of the sky through.
TEST(PatchScenes, BlendedPatchesLetTheirShareThrough) {
  Scene scene = test::patch_scene_of("sphere");
  scene.materials[0].albedo = {0, 0, 0};
  scene.materials[0].alpha.mode = AlphaMode::kBlend;
  scene.materials[0].alpha.value = 0.25f;
  scene.environment = {1, 1, 1};
  FrameSettings settings = settings_of(Renderer::kPath, 0, 64);
  settings.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 10};
  EXPECT_NEAR(mean_of(test::render(scene, settings)), 0.5625, 0.005);
}

// Pictures on patches lie along u and v, whatever the instance does to the patch.
TEST(PatchScenes, TexturesLieAlongTheParameters) {
  Scene scene = test::patch_scene_of("plane");
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = 64;
  texture->is_srgb = false;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (const int value : {4 * x, 4 * (63 - y), 0, 255})
        texture->rgba.push_back(static_cast<std::uint8_t>(value));
    }
  }
  scene.textures = {texture};
  scene.materials[0].albedo = {1, 1, 1};
  scene.materials[0].albedo_texture = TextureRef(0);
  scene.instances[0].object_to_world = test::turned_and_moved(2, {5, 1, 0}, false);
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  const PreparedScene::Impl& impl = (*prepared)->impl();
  const CheckedPatch plane = test::patch_shape("plane")[0];
  for (const float u : {0.2f, 0.5f, 0.7f}) {
    for (const float v : {0.3f, 0.6f}) {
      const PatchJet jet = evaluate(plane.patch(), double{u}, double{v});
      const Vec3f at = scene.instances[0].object_to_world.point({static_cast<float>(jet.point[0]),
                                                                 static_cast<float>(jet.point[1]),
                                                                 static_cast<float>(jet.point[2])});
      const Surface s = test::surface_towards(impl, at, {0.1f, 0.2f, -1});
      EXPECT_NEAR(s.albedo.x, u * 64 * 4 / 255 - 2 / 255.0f, 0.02f);
      EXPECT_NEAR(s.albedo.y, v * 64 * 4 / 255 - 2 / 255.0f, 0.02f);
    }
  }
}

TEST(PatchScenes, PicturesAreTheSameOnEveryInstructionSetAndTile) {
  Scene scene = test::patch_scene_of("teapot");
  scene.environment = {1, 1, 1};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    FrameSettings settings = settings_of(renderer, 2, 1);
    settings.camera = {{6, -6, 4}, {0, 0, 1.5f}, {0, 0, 1}, 45};
    const auto wanted = test::render_in_tiles(**prepared, settings, Isa::kScalar, 32);
    for (const Isa isa : test::isas_here()) {
      for (const int edge : {8, 16}) {
        EXPECT_TRUE(test::same_bits(wanted, test::render_in_tiles(**prepared, settings, isa, edge)))
            << renderer_name(renderer) << " " << isa_name(isa) << " " << edge;
      }
    }
  }
}

}  // namespace
}  // namespace tessera::core
