// SPDX-License-Identifier: Apache-2.0
#include "master/look/studio_sky.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/validate.h"

namespace tessera::master {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Radiance {
  Vec3f direction;
  double value, solid_angle;
};

template <class Visit>
void for_each_texel(const EnvironmentMap& map, Visit visit) {
  for (int row = 0; row < map.height_px; ++row) {
    const double theta = kPi * (row + 0.5) / map.height_px;
    for (int column = 0; column < map.width_px; ++column) {
      const double angle = 2 * kPi * ((column + 0.5) / map.width_px - 0.5);
      const double s = std::sin(theta);
      visit(Radiance{{static_cast<float>(s * std::sin(angle)), static_cast<float>(std::cos(theta)),
                      static_cast<float>(-s * std::cos(angle))},
                     map.rgb[3 * static_cast<std::size_t>(row * map.width_px + column)],
                     s * kPi / map.height_px * 2 * kPi / map.width_px});
    }
  }
}

// Irradiance over pi: what a white surface shows.
double white(const EnvironmentMap& map, Vec3f normal) {
  double sum = 0;
  for_each_texel(map, [&](const Radiance& r) {
    sum += std::max(0.0f, dot(r.direction, normalize(normal))) * r.value * r.solid_angle;
  });
  return sum / kPi;
}

TEST(StudioSky, ShowsWhiteAsWhiteOnTheKeySideAndOverhead) {
  const auto map = make_studio_sky({0, 0, 1});
  EXPECT_NEAR(white(*map, {-1, 1, 1}), 1, 0.1);  // the viewer's left, above
  EXPECT_NEAR(white(*map, {0, 1, 0}), 1, 0.1);
  EXPECT_LT(white(*map, {1, 0.2f, 1}), 0.8);  // the other side
  EXPECT_GT(white(*map, {0, -1, 0}), 0.1);    // nothing is black
}

TEST(StudioSky, IsNeutralAndValid) {
  const auto map = make_studio_sky({1, 2, 3});
  for (std::size_t i = 0; i < map->rgb.size(); i += 3) {
    ASSERT_EQ(map->rgb[i], map->rgb[i + 1]);
    ASSERT_EQ(map->rgb[i], map->rgb[i + 2]);
  }
  Scene scene;
  scene.materials.emplace_back();
  scene.environment = {1, 1, 1};
  scene.environment_map = map;
  EXPECT_TRUE(validate_scene(scene).is_ok());
}

TEST(StudioSky, KeyStandsToTheLeftOfEveryViewer) {
  for (const Vec3f viewer : {Vec3f{0, 0, 1}, Vec3f{1, 0, 0}, Vec3f{-0.6f, 0, -0.8f}}) {
    const auto map = make_studio_sky(viewer);
    const Vec3f left = cross({0, 1, 0}, -viewer);  // left of one who looks along -viewer
    EXPECT_GT(white(*map, left + viewer + Vec3f{0, 0.4f, 0}),
              1.3 * white(*map, viewer - left + Vec3f{0, 0.4f, 0}));
  }
}

TEST(StudioSky, HasAHorizon) {
  const auto map = make_studio_sky({0, 0, 1});
  double above = 0, below = 0;
  for_each_texel(*map, [&](const Radiance& r) {
    if (r.direction.y > 0.1f && r.direction.y < 0.2f) above += r.value * r.solid_angle;
    if (r.direction.y < -0.1f && r.direction.y > -0.2f) below += r.value * r.solid_angle;
  });
  EXPECT_GT(above, 1.5 * below);
}

}  // namespace
}  // namespace tessera::master
