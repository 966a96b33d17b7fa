// SPDX-License-Identifier: Apache-2.0
// For any mesh, direction, opening angle and aspect ratio: every vertex is in the picture, and the
// projection takes up 80 % of it.
#include "common/viewpoint/framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/scene/validate.h"
#include "tests/support/seed.h"

namespace tessera {
namespace {

constexpr std::uint32_t kSeed = 20261122;
constexpr int kScenes = 400;

Scene random_scene(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1), exponent(-20, 15);
  std::uniform_int_distribution<std::uint32_t> some(1, 400);
  Scene scene;
  scene.materials.resize(1);
  const float size = std::pow(10.0f, exponent(random));
  // Scenes are long, flat and far from the origin, up to a thousand times their size.
  const Vec3f shape{std::pow(10.0f, unit(random)), std::pow(10.0f, unit(random)),
                    std::pow(10.0f, unit(random))};
  const Vec3f away = std::pow(10.0f, 3 * unit(random)) * Vec3f{unit(random), unit(random), 0};
  for (int i = 0; i < 2; ++i) {
    auto mesh = std::make_shared<Mesh>();
    const std::uint32_t count = some(random) + 2;
    for (std::uint32_t v = 0; v < count; ++v) {
      mesh->positions.push_back(size *
                                (shape * Vec3f{unit(random), unit(random), unit(random)} + away));
    }
    for (std::uint32_t v = 0; v + 2 < count; ++v) mesh->triangles.push_back({v, v + 1, v + 2});
    mesh->materials = {0};
    scene.meshes.push_back(mesh);
  }
  for (std::uint32_t i = 0; i < 5; ++i) {
    Instance instance{i % 2, {}};
    for (auto& row : instance.object_to_world.m) {
      for (std::size_t j = 0; j < 3; ++j) row[j] += 0.5f * unit(random);
      row[3] = size * unit(random);
    }
    scene.instances.push_back(instance);
  }
  return scene;
}

struct Extent {
  double low = 1e300, high = -1e300;
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double size() const { return high - low; }
};

TEST(FramingProperty, VerticesTakeUpTheirShareOfThePicture) {
  std::mt19937 random(test::seed(kSeed));
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int n = 0; n < kScenes; ++n) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", scene " + std::to_string(n));
    const Scene scene = random_scene(random);
    Framing framing;
    framing.view = {unit(random), unit(random), unit(random)};
    framing.vfov_degrees = 45 + 40 * unit(random);
    framing.aspect = std::pow(4, unit(random));
    const Camera camera = framed_camera(SupportMap(scene), framing);
    ASSERT_TRUE(validate_camera(camera).is_ok());
    // Vertices are projected as by a renderer, in doubles.
    const Vec3d eye = widened(camera.eye), ahead = normalize(widened(camera.target) - eye);
    const Vec3d right = normalize(cross(ahead, widened(camera.up))), above = cross(right, ahead);
    const double tan_half = std::tan(camera.vfov_degrees * std::numbers::pi / 360);
    Extent across, up;
    double nearest = 1e300, coordinate = std::max(length(eye), length(widened(camera.target)));
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = *scene.meshes[instance.mesh];
      for (const Vec3f p : mesh.positions) {
        const Vec3d offset = widened(instance.object_to_world.point(p)) - eye;
        const double depth = dot(offset, ahead);
        ASSERT_GT(depth, 0);
        nearest = std::min(nearest, depth);
        coordinate = std::max(coordinate, length(offset + eye));
        across.add(dot(offset, right) / (depth * tan_half * framing.aspect));
        up.add(dot(offset, above) / (depth * tan_half));
      }
    }
    // The bound of framing.h, for both ends and in shares of half the picture's sides, and the
    // transform of a vertex in floats (seven roundings of 2^-24).
    const double bound =
        4 * (1 + std::max(1.0, 1 / framing.aspect) / tan_half) *
        std::ldexp(coordinate / std::min(nearest, length(widened(camera.target) - eye)), -21);
    EXPECT_NEAR(std::max(across.size(), up.size()) / 2, kFramedShare, bound);
    EXPECT_LE(std::max({across.high, -across.low, up.high, -up.low}), kFramedShare + bound);
    EXPECT_NEAR(across.high + across.low, 0, bound);
    EXPECT_NEAR(up.high + up.low, 0, bound);
    EXPECT_LT(bound, 0.05);  // else the comparison says nothing
  }
}

}  // namespace
}  // namespace tessera
