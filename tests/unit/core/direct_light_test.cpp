// SPDX-License-Identifier: Apache-2.0
// Direct light against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "slave/core/light/light_set.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

Material lamp_material(Vec3f emission) {
  Material material;
  material.name = "lamp";
  material.albedo = {};
  material.emission = emission;
  return material;
}

constexpr double kPi = 3.14159265358979323846;

void add_quad(Mesh& mesh, Vec3f a, Vec3f b, Vec3f c, Vec3f d, std::uint32_t material) {
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
  mesh.triangles.push_back({n, n + 1, n + 2});
  mesh.triangles.push_back({n, n + 2, n + 3});
  mesh.materials.insert(mesh.materials.end(), 2, material);
}

// A floor y = 0 of half edge `half`, albedo 0.5.
Mesh make_floor(float half) {
  Mesh mesh;
  add_quad(mesh, {-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}, 0);
  return mesh;
}

Scene make_lit(Mesh mesh) {
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials[0].albedo = {0.5f, 0.5f, 0.5f};
  return scene;
}

// A camera at height 2 sees the floor straight from above; x_of() and z_of() are what a pixel sees.
struct View {
  FrameSettings settings;
  View() {
    settings.width_px = settings.height_px = 32;
    settings.camera = {{0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 53.130102f};  // sees [-1, 1]^2
  }
  static double x_of(int x) { return (x + 0.5) / 16 - 1; }
  static double z_of(int y) { return (y + 0.5) / 16 - 1; }
};

using test::render;

float pixel(const std::vector<float>& rgb, int x, int y) {
  return rgb[3 * static_cast<std::size_t>(y * 32 + x)];
}

TEST(DirectLight, PointLightAboveAPlaneIsTheClosedForm) {
  Scene scene = make_lit(make_floor(3));
  scene.lights.push_back({LightKind::kPoint, {0.3f, 1, 0.2f}, {}, {2, 2, 2}, 1, 0});
  const View view;
  const std::vector<float> rgb = render(scene, view.settings);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const double dx = 0.3 - View::x_of(x), dz = 0.2 - View::z_of(y), r2 = dx * dx + 1 + dz * dz;
      const double expected = 0.5 / kPi * 2 / (r2 * std::sqrt(r2));
      EXPECT_NEAR(expected, pixel(rgb, x, y), 1e-4 * expected) << x << " " << y;
    }
  }
}

TEST(DirectLight, SpotAndDirectionalAreTheClosedForm) {
  Scene scene = make_lit(make_floor(3));
  scene.lights.push_back({LightKind::kSpot, {0, 1, 0}, {0, -2, 0}, {2, 2, 2}, 0.9f, 0.8f});
  const View view;
  std::vector<float> rgb = render(scene, view.settings);
  for (int x = 0; x < 32; ++x) {
    const double px = View::x_of(x), pz = View::z_of(16), r2 = px * px + 1 + pz * pz;
    const double cosine = 1 / std::sqrt(r2), k = std::min(1.0, std::max(0.0, (cosine - 0.8) / 0.1));
    EXPECT_NEAR(0.5 / kPi * 2 * cosine / r2 * k * k, pixel(rgb, x, 16), 2e-6) << x;
  }
  scene.lights = {{LightKind::kDirectional, {}, {3, -4, 0}, {2, 2, 2}, 1, 0}};
  rgb = render(scene, view.settings);
  for (int x = 0; x < 32; ++x) EXPECT_NEAR(0.5 / kPi * 2 * 0.8, pixel(rgb, x, 7), 1e-6);
}

TEST(DirectLight, ShadowFallsWhereTheBlockerStands) {
  Mesh mesh = make_floor(3);
  // This quad blocks the light from (0, 1, 0) half way up, so that its shadow is twice as large:
  // [0.2, 0.6] x [-0.4, 0.4].
  add_quad(mesh, {0.1f, 0.5f, 0.2f}, {0.3f, 0.5f, 0.2f}, {0.3f, 0.5f, -0.2f}, {0.1f, 0.5f, -0.2f},
           0);
  Scene scene = make_lit(mesh);
  scene.lights.push_back({LightKind::kPoint, {0, 1, 0}, {}, {2, 2, 2}, 1, 0});
  View view;
  const std::vector<float> rgb = render(scene, view.settings);
  // From the camera at height 2 the blocker itself covers floor x in [0.133, 0.4].
  EXPECT_EQ(0.0f, pixel(rgb, 24, 16));  // x = 0.53
  EXPECT_GT(pixel(rgb, 26, 16), 0.0f);  // x = 0.66
  EXPECT_GT(pixel(rgb, 16, 16), 0.0f);  // x = 0.03
}

// Irradiance below the centre of a square of edge 2 a at height h, radiance 1 (view factor of a
// differential patch to a rectangle through its corner, four times; Howell, "A catalog of radiation
// heat transfer configuration factors", B-4), times pi.
double irradiance_under_square(double a, double h) {
  const double x = a / h, r = std::sqrt(1 + x * x);
  return 4 * (x / r * std::atan(x / r));
}

TEST(DirectLight, SquareLampAboveAPointIsTheClosedForm) {
  Mesh mesh = make_floor(3);
  add_quad(mesh, {-0.5f, 3, -0.5f}, {0.5f, 3, -0.5f}, {0.5f, 3, 0.5f}, {-0.5f, 3, 0.5f},
           1);  // emits down
  Scene scene = make_lit(mesh);
  scene.materials.push_back(lamp_material({7, 7, 7}));
  View view;
  view.settings.width_px = view.settings.height_px = 1;
  view.settings.camera.vfov_degrees = 0.01f;
  view.settings.light_samples = 256;
  const std::vector<float> rgb = render(scene, view.settings);
  const double expected = 0.5 / kPi * 7 * irradiance_under_square(0.5, 3);
  EXPECT_NEAR(expected, rgb[0], 1e-3 * expected);
}

TEST(DirectLight, EmissionIsOneSided) {
  Mesh mesh;
  add_quad(mesh, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}, 0);  // emits up
  Scene scene = make_lit(mesh);
  scene.materials[0].emission = {3, 3, 3};
  View view;
  EXPECT_EQ(3.0f, pixel(render(scene, view.settings), 16, 16));
  view.settings.camera.eye = {0, -2, 0};
  EXPECT_EQ(0.0f, pixel(render(scene, view.settings), 16, 16));
}

TEST(DirectLight, ManyEmittersSharedOutByPowerHaveTheRightMean) {
  Mesh mesh = make_floor(3);
  // The square lamp above, cut into 10 x 10 squares. These are 200 triangles, more than are sampled
  // one by one.
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      const float x = -0.5f + 0.1f * static_cast<float>(i),
                  z = -0.5f + 0.1f * static_cast<float>(j);
      add_quad(mesh, {x, 3, z}, {x + 0.1f, 3, z}, {x + 0.1f, 3, z + 0.1f}, {x, 3, z + 0.1f}, 1);
    }
  }
  ASSERT_GT(200u, kEmittersEachMax);
  Scene scene = make_lit(mesh);
  scene.materials.push_back(lamp_material({7, 7, 7}));
  View view;
  view.settings.camera.vfov_degrees = 0.01f;
  view.settings.light_samples = 16;
  const std::vector<float> rgb = render(scene, view.settings);
  double mean = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) mean += rgb[i] / 1024.0;
  const double expected = 0.5 / kPi * 7 * irradiance_under_square(0.5, 3);
  EXPECT_NEAR(expected, mean, 2e-3 * expected);
}

// A convex room that is lit by a point inside has no shadow: every wall point must see the light,
// wherever in the world and at whatever scale the room stands.
TEST(DirectLight, SecondaryRaysNeitherHitTheirOwnSurfaceNorTheNext) {
  struct Place {
    float scale;
    Vec3f offset;
  };
  const Place places[] = {
      {1, {}}, {1, {1000, -2000, 500}}, {1e-4f, {}}, {1e5f, {}}, {100, {1e5f, 0, 1e5f}}};
  for (const Place& place : places) {
    Mesh mesh = test::make_icosphere(3);
    test::place(mesh, place.scale, place.offset);
    Scene scene = make_lit(mesh);
    const float power = place.scale * place.scale;
    const Vec3f light = Vec3f{0.1f, 0.2f, -0.1f} * place.scale + place.offset;
    scene.lights.push_back({LightKind::kPoint, light, {}, {power, power, power}, 1, 0});
    FrameSettings settings;
    settings.width_px = settings.height_px = 64;
    settings.camera = {
        place.offset, place.offset + Vec3f{1, 0.3f, 0.2f} * place.scale, {0, 1, 0}, 120};
    const std::vector<float> rgb = render(scene, settings);
    for (std::size_t i = 0; i < rgb.size(); i += 3) {
      ASSERT_GT(rgb[i], 0.05f) << "scale " << place.scale << " pixel " << i / 3;
    }
  }
}

}  // namespace
}  // namespace tessera::core
