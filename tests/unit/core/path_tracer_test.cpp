// Light over several surfaces against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

struct Picture {
  double mean = 0, least = 1e30, greatest = 0;
};

Picture render(const Scene& scene, const FrameSettings& settings) {
  const std::vector<float> rgb = test::render(scene, settings);
  Picture picture;
  for (const float x : rgb) {
    EXPECT_TRUE(std::isfinite(x));
    picture.mean += x / static_cast<double>(rgb.size());
    picture.least = std::min<double>(picture.least, x);
    picture.greatest = std::max<double>(picture.greatest, x);
  }
  return picture;
}

FrameSettings path_settings(int bounces, int samples) {
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.camera = {{0.1f, 0.05f, 0}, {1, 0.2f, 0.3f}, {0, 1, 0}, 90};
  settings.renderer = Renderer::kPath;
  settings.bounces = bounces;
  settings.samples_per_pixel = samples;
  return settings;
}

// A sphere seen from within, of the given material.
Scene make_inside(float albedo, float emission) {
  Mesh mesh = test::make_icosphere(2);
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // emission goes inwards
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials[0].albedo = {albedo, albedo, albedo};
  scene.materials[0].emission = {emission, emission, emission};
  return scene;
}

// Everything emits 1 and reflects a: after k surfaces 1 + a + ... + a^k is seen, whatever the shape.
TEST(PathTracer, FurnaceIsTheGeometricSeries) {
  for (const float albedo : {0.3f, 0.8f}) {
    for (const int bounces : {0, 1, 4}) {
      double expected = 0;
      for (int k = 0; k <= bounces + 1; ++k) expected += std::pow(albedo, k);
      const Picture picture = render(make_inside(albedo, 1), path_settings(bounces, 64));
      EXPECT_NEAR(picture.mean, expected, 0.005 * expected) << albedo << " " << bounces;
    }
  }
}

// With many bounces it comes to 1 / (1 - albedo).
TEST(PathTracer, FurnaceWithManyBouncesIsTheClosedForm) {
  const Picture picture = render(make_inside(0.6f, 1), path_settings(24, 64));
  EXPECT_NEAR(picture.mean, 1 / (1 - 0.6), 0.005 / (1 - 0.6));
}

// A convex body under an even sky reflects its albedo, in every sample: nothing of the sky is hidden.
TEST(PathTracer, ConvexBodyUnderAnEvenSkyReflectsItsAlbedo) {
  Scene scene = test::make_scene(test::make_icosphere(3));
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.environment = {1, 1, 1};
  FrameSettings settings = path_settings(3, 1);
  settings.camera = {{0, 0, 1.2f}, {0, 0, 0}, {0, 1, 0}, 30};  // nothing but the body
  for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
    settings.renderer = renderer;
    const Picture picture = render(scene, settings);
    EXPECT_NEAR(picture.least, 0.7, 1e-6) << renderer_name(renderer);
    EXPECT_NEAR(picture.greatest, 0.7, 1e-6) << renderer_name(renderer);
  }
}

// In a closed sphere every point sees every other by the same form factor: light that one point lamp
// brings in is even after one bounce. Radiance from a lamp of intensity I in the middle of a sphere of
// radius 1: a / pi * I * (1 + a + ... ), since the mean irradiance of a sphere's inside is that of its
// walls' radiance times pi.
TEST(PathTracer, SphereWithALampInItsMiddleIsTheClosedForm) {
  const float albedo = 0.5f;
  Scene scene = make_inside(albedo, 0);
  scene.lights.push_back({LightKind::kPoint, {0, 0, 0}, {}, {2, 2, 2}, 1, 0});
  for (const int bounces : {0, 3}) {
    double series = 0;
    for (int k = 0; k <= bounces; ++k) series += std::pow(albedo, k);
    const Picture picture = render(scene, path_settings(bounces, 64));
    // The sphere of 320 triangles lies within its corners: its walls are up to 3 % closer.
    const double expected = albedo / 3.14159265 * 2 * series;
    EXPECT_GT(picture.mean, expected) << bounces;
    EXPECT_LT(picture.mean, 1.06 * expected) << bounces;
  }
}

// Zero bounces are what the direct renderer shows.
TEST(PathTracer, WithoutBouncesItIsDirectLight) {
  Scene scene = make_inside(0.5f, 0);
  scene.lights.push_back({LightKind::kPoint, {0.2f, 0.1f, 0.3f}, {}, {2, 2, 2}, 1, 0});
  FrameSettings settings = path_settings(0, 4);
  const Picture path = render(scene, settings);
  settings.renderer = Renderer::kDirect;
  EXPECT_EQ(path.mean, render(scene, settings).mean);
}

// Half shadow of a lamp of several triangles, one of which is picked for each sample: as bright, pixel
// by pixel, as where each gets samples of its own. (Once the pick decided on the place, too.)
TEST(PathTracer, HalfShadowsAreThoseOfDirectLight) {
  Mesh mesh;
  mesh.positions = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4},  {-4, 0, 4}, {-1, 2, -1}, {1, 2, -1},
                    {1, 2, 1},   {-1, 2, 1}, {0, 1, -4}, {0, 1, 4},  {4, 1, 4},   {4, 1, -4}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {8, 9, 10}, {8, 10, 11}};
  mesh.materials = {0, 0, 1, 1, 0, 0};
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[1] = {"lamp", {0, 0, 0}, {3, 3, 3}, kNoTexture};
  FrameSettings settings = path_settings(0, 1024);
  settings.width_px = settings.height_px = 16;
  settings.camera = {{-1.5f, 0.9f, 0}, {-0.5f, 0, 0}, {0, 0, 1}, 60};
  const std::vector<float> path = test::render(scene, settings);
  settings.renderer = Renderer::kDirect;
  settings.samples_per_pixel = 64;
  settings.light_samples = 16;
  const std::vector<float> direct = test::render(scene, settings);
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_NEAR(path[i], direct[i], 0.01f) << i;
}

}  // namespace
}  // namespace tessera::core
