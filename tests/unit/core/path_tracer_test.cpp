// SPDX-License-Identifier: Apache-2.0
// Light over several surfaces against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/bsdf_at.h"
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

// Everything emits 1 and reflects a, so that 1 + a + ... + a^k is seen after k surfaces.
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

// With many bounces the series comes to 1 / (1 - albedo).
TEST(PathTracer, FurnaceWithManyBouncesIsTheClosedForm) {
  const Picture picture = render(make_inside(0.6f, 1), path_settings(24, 64));
  EXPECT_NEAR(picture.mean, 1 / (1 - 0.6), 0.005 / (1 - 0.6));
}

// A convex body under an even sky reflects its albedo in every sample: it hides no sky from itself.
TEST(PathTracer, ConvexBodyUnderAnEvenSkyReflectsItsAlbedo) {
  Scene scene = test::make_scene(test::make_icosphere(3));
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.environment = {1, 1, 1};
  FrameSettings settings = path_settings(3, 1);
  settings.camera = {{0, 0, 1.2f}, {0, 0, 0}, {0, 1, 0}, 30};  // sees nothing but the body
  for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
    settings.renderer = renderer;
    const Picture picture = render(scene, settings);
    EXPECT_NEAR(picture.least, 0.7, 1e-6) << renderer_name(renderer);
    EXPECT_NEAR(picture.greatest, 0.7, 1e-6) << renderer_name(renderer);
  }
}

// In a closed sphere every point sees every other by the same form factor, so that the light of a
// point lamp is even after one bounce. A lamp of intensity I in the middle of a sphere of radius 1
// gives the radiance a / pi * I * (1 + a + ... ), since the mean irradiance of a sphere's inside is
// the radiance of its walls times pi.
TEST(PathTracer, SphereWithALampInItsMiddleIsTheClosedForm) {
  const float albedo = 0.5f;
  Scene scene = make_inside(albedo, 0);
  scene.lights.push_back({LightKind::kPoint, {0, 0, 0}, {}, {2, 2, 2}, 1, 0});
  for (const int bounces : {0, 3}) {
    double series = 0;
    for (int k = 0; k <= bounces; ++k) series += std::pow(albedo, k);
    const Picture picture = render(scene, path_settings(bounces, 64));
    // The walls of the sphere of 320 triangles are up to 3 % closer than its corners.
    const double expected = albedo / 3.14159265 * 2 * series;
    EXPECT_GT(picture.mean, expected) << bounces;
    EXPECT_LT(picture.mean, 1.06 * expected) << bounces;
  }
}

// With zero bounces the path tracer shows what the direct renderer shows.
TEST(PathTracer, WithoutBouncesItIsDirectLight) {
  Scene scene = make_inside(0.5f, 0);
  scene.lights.push_back({LightKind::kPoint, {0.2f, 0.1f, 0.3f}, {}, {2, 2, 2}, 1, 0});
  FrameSettings settings = path_settings(0, 4);
  const Picture path = render(scene, settings);
  settings.renderer = Renderer::kDirect;
  EXPECT_EQ(path.mean, render(scene, settings).mean);
}

// Half shadows of a lamp of several triangles, one of which the path tracer picks for each sample,
// are as bright, pixel by pixel, as where each gets samples of its own. (The pick once decided on
// the place in the triangle, too.)
TEST(PathTracer, HalfShadowsAreThoseOfDirectLight) {
  Mesh mesh;
  mesh.positions = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4},  {-4, 0, 4}, {-1, 2, -1}, {1, 2, -1},
                    {1, 2, 1},   {-1, 2, 1}, {0, 1, -4}, {0, 1, 4},  {4, 1, 4},   {4, 1, -4}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {8, 9, 10}, {8, 10, 11}};
  mesh.materials = {0, 0, 1, 1, 0, 0};
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[1].name = "lamp";
  scene.materials[1].albedo = {0, 0, 0};
  scene.materials[1].emission = {3, 3, 3};
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

// A closed glass body takes nothing and adds nothing: under an even sky it cannot be seen. What is
// missing is what chains of more than kSpecularDepthMax would bring.
TEST(PathTracer, GlassAndMirrorUnderAnEvenSkyCannotBeSeen) {
  Mesh ball = test::make_icosphere(4);
  ball.normals = ball.positions;
  Scene scene = test::make_scene(std::move(ball));
  scene.environment = {1, 1, 1};
  scene.materials[0].specular = {1, 1, 1};
  FrameSettings settings = path_settings(0, 16);
  settings.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 30};
  for (const BsdfKind kind : {BsdfKind::kMirror, BsdfKind::kGlass}) {
    scene.materials[0].bsdf = kind;
    for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
      settings.renderer = renderer;
      const Picture picture = render(scene, settings);
      EXPECT_NEAR(picture.mean, 1, 0.002) << renderer_name(renderer);
      EXPECT_LE(picture.greatest, 1.0001);
    }
  }
}

TEST(PathTracer, WhiteMetalAndPlasticUnderAnEvenSkyCannotBeSeen) {
  Scene scene = test::make_scene(test::make_icosphere(4));
  scene.environment = {1, 1, 1};
  scene.materials[0].albedo = {1, 1, 1};
  scene.materials[0].bsdf = BsdfKind::kGlossy;
  FrameSettings settings = path_settings(0, 64);
  settings.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 30};
  settings.light_samples = 1;
  for (const float roughness : {0.1f, 0.5f, 1.0f}) {
    for (const float metalness : {0.0f, 1.0f}) {
      scene.materials[0].roughness = roughness;
      scene.materials[0].metalness = metalness;
      for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
        settings.renderer = renderer;
        EXPECT_NEAR(render(scene, settings).mean, 1, 0.01) << roughness << " " << metalness;
      }
    }
  }
}

// A floor of material 0 with albedo 0.5 that a lamp of radiance 3, edges 2 and height 1 lights, and
// a camera that sees one point of it, at an angle.
struct Lamp {
  static constexpr float kHeight = 1, kRadiance = 3;
  Scene scene;
  // All pixels see the one point; each has its own scrambling of one sequence.
  FrameSettings settings = path_settings(0, 16);
  Vec3f point{-0.8f, 0, 0}, to_eye{1.5f, 0.9f, 0.4f};

  explicit Lamp(bool has_mirror) {
    Mesh mesh;
    mesh.materials.clear();
    test::add_quad(mesh, {-9, 0, 9}, {18, 0, 0}, {0, 0, -18}, 0);
    test::add_quad(mesh, {-1, kHeight, -1}, {2, 0, 0}, {0, 0, 2}, 1);
    if (has_mirror) test::add_quad(mesh, {-1.05f, 0, 9}, {0, 9, 0}, {0, 0, -18}, 2);
    scene = test::make_scene(std::move(mesh));
    scene.materials.resize(3);
    scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
    scene.materials[1].albedo = {0, 0, 0};
    scene.materials[1].emission = {kRadiance, kRadiance, kRadiance};
    scene.materials[2].bsdf = BsdfKind::kMirror;
    scene.materials[2].specular = {0.75f, 0.75f, 0.75f};
    settings.width_px = settings.height_px = 128;
    settings.camera = {point + to_eye, point, {0, 1, 0}, 0.01f};
  }

  // Light of the lamp, with its middle moved to x, that the point sends to the eye by its BSDF,
  // summed in double over a grid.
  double expected(float x) const {
    Surface s;
    s.normal = s.shading_normal = {0, 1, 0};
    s.bsdf = scene.materials[0].bsdf;
    s.albedo = scene.materials[0].albedo;
    s.roughness = scene.materials[0].roughness;
    s.metalness = scene.materials[0].metalness;
    s.material = &scene.materials[0];
    const Vec3f to_viewer = normalize(to_eye);
    double sum = 0;
    constexpr int kGrid = 500;
    for (int i = 0; i < kGrid; ++i) {
      for (int j = 0; j < kGrid; ++j) {
        const auto at = [](int k) { return 2 * (static_cast<float>(k) + 0.5f) / kGrid - 1; };
        const Vec3f away = Vec3f{x + at(i), kHeight, at(j)} - point;
        const double r2 = dot(away, away), cosine = kHeight / std::sqrt(r2);
        sum += test::evaluate(s, to_viewer, normalize(away)).times_pi.x * cosine * cosine / r2;
      }
    }
    return sum * 4 / (double{kGrid} * kGrid) * kRadiance / 3.14159265358979;
  }
};

// Light samples and BSDF samples share a lamp by MIS weights, and their sum is the integral.
TEST(PathTracer, AGlossyFloorUnderALampIsTheIntegral) {
  Lamp lamp(false);
  lamp.scene.materials[0].bsdf = BsdfKind::kGlossy;
  lamp.scene.materials[0].specular = {0.3f, 0.3f, 0.3f};
  for (const float metalness : {0.0f, 1.0f}) {
    for (const float roughness : {0.2f, 0.45f, 0.9f}) {
      lamp.scene.materials[0].metalness = metalness;
      lamp.scene.materials[0].roughness = roughness;
      const double expected = lamp.expected(0);
      for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
        lamp.settings.renderer = renderer;
        EXPECT_NEAR(render(lamp.scene, lamp.settings).mean, expected, 0.01 * expected)
            << renderer_name(renderer) << " " << metalness << " " << roughness;
      }
    }
  }
}

// The floor beside a mirror is lit by the lamp and by its image; no light sample finds the image.
TEST(PathTracer, AMirrorThrowsLightOntoADiffuseFloor) {
  const Lamp lamp(true);
  const double direct = lamp.expected(0), image = 0.75 * lamp.expected(-2.1f);
  ASSERT_GT(image, 0.2 * direct);
  const double seen = render(lamp.scene, lamp.settings).mean;
  EXPECT_NEAR(seen, direct + image, 0.03 * image);
}

// Distance from the eye to z = 0 through the image point (x, y) in [-1, 1]^2, in double.
double distance_of_plane(const Camera& camera, double x, double y) {
  const Vec3f forward = normalize(camera.target - camera.eye);
  const Vec3f right = normalize(cross(forward, camera.up)), up = cross(right, forward);
  const double edge = std::tan(camera.vfov_degrees * 3.14159265358979 / 360);
  const double dx = forward.x + edge * (x * right.x + y * up.x);
  const double dy = forward.y + edge * (x * right.y + y * up.y);
  const double dz = forward.z + edge * (x * right.z + y * up.z);
  return -camera.eye.z / dz * std::sqrt(dx * dx + dy * dy + dz * dz);
}

// A mirror shows what a camera behind it would see, with left and right exchanged.
TEST(PathTracer, AMirrorShowsWhatASecondCameraWouldSee) {
  Mesh mesh = test::make_torus(24, 12);
  test::place(mesh, 0.4f, {0.3f, 0.2f, 1.2f});
  mesh.materials.assign(mesh.triangles.size(), 0);
  test::add_quad(mesh, {-9, -0.5f, 9}, {18, 0, 0}, {0, 0, -8.9f}, 0);
  Mesh with_mirror = mesh;
  test::add_quad(with_mirror, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, 1);
  Scene scene = test::make_scene(with_mirror);
  scene.materials.resize(2);
  scene.materials[1].bsdf = BsdfKind::kMirror;
  scene.materials[1].specular = {1, 1, 1};
  scene.lights.push_back({LightKind::kPoint, {1, 3, 2}, {}, {9, 9, 9}, 1, 0});
  Scene second = scene;
  second.meshes = {std::make_shared<const Mesh>(mesh)};
  FrameSettings settings = path_settings(0, 1);
  settings.width_px = settings.height_px = 64;
  settings.renderer = Renderer::kDirect;
  settings.camera = {{0.5f, 0.6f, 3}, {0.2f, 0.1f, -1}, {0, 1, 0}, 40};
  FrameSettings behind = settings;
  behind.camera.eye.z = -3;
  behind.camera.target.z = 1;
  const auto shown = test::render(scene, settings), seen = test::render(second, behind);
  settings.renderer = Renderer::kPrimary;
  const auto distance = test::render(scene, settings);
  int different = 0, lit = 0;
  for (std::size_t y = 0; y < 64; ++y) {
    for (std::size_t x = 0; x < 64; ++x) {
      const std::size_t here = y * 64 + x, there = y * 64 + 63 - x;
      // Only pixels count that see the mirror first, which is the plane z = 0 along this ray.
      const double dx = (static_cast<double>(x) + 0.5) / 32 - 1;
      const double dy = 1 - (static_cast<double>(y) + 0.5) / 32;
      if (std::fabs(distance[3 * here] - distance_of_plane(settings.camera, dx, dy)) > 1e-4)
        continue;
      const float a = shown[3 * here], b = seen[3 * there];
      lit += b > 0.01f;
      different += std::fabs(a - b) > 1e-3f * (1 + b);
    }
  }
  EXPECT_GT(lit, 300);
  EXPECT_LT(different, 20) << "but for borders, where a rounding decides";
}

TEST(PathTracer, ALampInAMirrorIsAsBrightAsTheMirrorLeavesIt) {
  Mesh mesh;
  test::add_quad(mesh, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, 0);
  test::add_quad(mesh, {-9, -9, 9}, {0, 18, 0}, {18, 0, 0}, 1);  // behind the camera, shining on it
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[0].bsdf = BsdfKind::kMirror;
  scene.materials[0].specular = {0.25f, 0.5f, 0.75f};
  scene.materials[1].emission = {8, 8, 8};
  scene.materials[1].albedo = {0, 0, 0};
  FrameSettings settings = path_settings(2, 1);
  settings.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 30};
  for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
    settings.renderer = renderer;
    const Picture picture = render(scene, settings);
    EXPECT_NEAR(picture.least, 2, 1e-5);
    EXPECT_NEAR(picture.greatest, 6, 1e-5);
  }
}

// Paths between two mirrors that face each other end, without light.
TEST(PathTracer, MirrorsThatFaceEachOtherAreLeftInTheEnd) {
  Mesh mesh;
  test::add_quad(mesh, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, 0);
  test::add_quad(mesh, {-9, -9, 4}, {0, 18, 0}, {18, 0, 0}, 0);
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials[0].bsdf = BsdfKind::kMirror;
  scene.materials[0].specular = {1, 1, 1};
  scene.environment = {1, 1, 1};
  FrameSettings settings = path_settings(2, 1);
  settings.camera = {{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 10};
  EXPECT_EQ(render(scene, settings).greatest, 0);
}

}  // namespace
}  // namespace tessera::core
