// SPDX-License-Identifier: Apache-2.0
// Textures as glTF files ask for them: wrapping, nearest and bilinear texels, 16 bits, the set of
// coordinates that they follow and how they are placed there.
#include "slave/core/surface/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/surface_at.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// A linear texture of one row of greys.
Texture make_row(std::initializer_list<std::uint8_t> greys) {
  Texture t;
  t.width_px = static_cast<int>(greys.size());
  t.height_px = 1;
  t.is_srgb = false;
  for (const std::uint8_t g : greys) t.rgba.insert(t.rgba.end(), {g, g, g, 255});
  return t;
}

float at(const Texture& t, float u) { return sample_texture(t, {u, 0.5f}).x * 255; }

// The four texels' middles are at 1/8, 3/8, 5/8 and 7/8. 1e-3: some roundings of 255.
TEST(Texture, EdgesRepeatMirrorOrStay) {
  Texture t = make_row({0, 80, 160, 240});
  EXPECT_NEAR(at(t, 0), 120, 1e-3);  // between the last and the first
  EXPECT_NEAR(at(t, 1.125f), 0, 1e-3);
  EXPECT_NEAR(at(t, -0.125f), 240, 1e-3);
  t.wrap_u = TextureWrap::kClamp;
  EXPECT_NEAR(at(t, 0), 0, 1e-3);
  EXPECT_NEAR(at(t, -7), 0, 1e-3);
  EXPECT_NEAR(at(t, 0.25f), 40, 1e-3);
  EXPECT_NEAR(at(t, 0.9f), 240, 1e-3);
  EXPECT_NEAR(at(t, 1e30f), 240, 1e-3);
  t.wrap_u = TextureWrap::kMirror;
  for (const float u : {0.0f, 0.1f, 0.3f, 0.5f, 0.77f, 1.0f}) {
    EXPECT_NEAR(at(t, -u), at(t, u), 1e-3) << u;
    EXPECT_NEAR(at(t, 2 - u), at(t, u), 1e-3) << u;
    EXPECT_NEAR(at(t, 6 + u), at(t, u), 1e-3) << u;
  }
  EXPECT_NEAR(at(t, 1), 240, 1e-3);
  EXPECT_NEAR(at(t, 1.625f), 80, 1e-3);
}

TEST(Texture, AxesWrapEachInItsOwnWay) {
  Texture t = make_row({0, 80, 160, 240});
  std::swap(t.width_px, t.height_px);
  t.wrap_u = TextureWrap::kClamp;
  t.wrap_v = TextureWrap::kMirror;
  EXPECT_NEAR(sample_texture(t, {9, 0.125f}).x * 255, 240, 1e-3);  // row 0 is on top
  EXPECT_NEAR(sample_texture(t, {9, -0.125f}).x * 255, 240, 1e-3);
  EXPECT_NEAR(sample_texture(t, {9, 1.125f}).x * 255, 0, 1e-3);
}

TEST(Texture, NearestTexelsAreSquares) {
  Texture t = make_row({0, 80, 160, 240});
  t.is_nearest = true;
  for (const TextureWrap wrap : {TextureWrap::kRepeat, TextureWrap::kMirror, TextureWrap::kClamp}) {
    t.wrap_u = wrap;
    for (const float u : {0.0f, 0.01f, 0.24f, 0.26f, 0.49f, 0.51f, 0.74f, 0.76f, 0.99f})
      EXPECT_NEAR(at(t, u), std::floor(4 * u) * 80, 1e-3) << u;
  }
  EXPECT_NEAR(at(t, 1), 240, 1e-3);  // clamped
  t.wrap_u = TextureWrap::kRepeat;
  EXPECT_EQ(at(t, 1), 0);
  EXPECT_EQ(at(t, -1e-9f), 0);  // rounds to 1, which is the next image's 0
}

Texture make_ramp(bool is_srgb) {
  Texture t;
  t.width_px = 256;
  t.height_px = 256;
  t.is_srgb = is_srgb;
  t.is_nearest = true;
  for (std::uint32_t i = 0; i < 65536; ++i) {
    const auto grey = static_cast<std::uint16_t>(i);
    t.rgba16.insert(t.rgba16.end(), {grey, grey, grey, static_cast<std::uint16_t>(65535 - i)});
  }
  return t;
}

TEST(Texture, SixteenBitsAre65536Levels) {
  for (const bool is_srgb : {false, true}) {
    const Texture t = make_ramp(is_srgb);
    float before = -1;
    for (int i = 0; i < 65536; ++i) {
      const Vec2f uv{(static_cast<float>(i % 256) + 0.5f) / 256,
                     1 - (static_cast<float>(i / 256) + 0.5f) / 256};
      const double e = i / 65535.0;
      const double linear = !is_srgb       ? e
                            : e <= 0.04045 ? e / 12.92
                                           : std::pow((e + 0.055) / 1.055, 2.4);
      const float grey = sample_texture(t, uv).x;
      ASSERT_GT(grey, before) << i;
      ASSERT_NEAR(grey, linear, 1.2e-7 * linear) << i;  // two roundings
      ASSERT_NEAR(sample_channel(t, uv, 3), 1 - e, 1e-7) << i;
      before = grey;
    }
  }
}

// The texture is noise between 20000 and 20255, of which a mip map of bytes would know two values.
TEST(Texture, LevelsKeepSixteenBitsAndAlpha) {
  Texture t;
  t.width_px = t.height_px = 64;
  t.is_srgb = false;
  double grey = 0, alpha = 0;
  for (std::uint32_t i = 0; i < 64 * 64; ++i) {
    const std::uint32_t noise = i * 2654435761u >> 24;
    const auto c = static_cast<std::uint16_t>(20000 + noise);
    const auto a = static_cast<std::uint16_t>(65535 - 200 * noise);
    t.rgba16.insert(t.rgba16.end(), {c, c, c, a});
    grey += c / 65535.0 / (64 * 64);
    alpha += a / 65535.0 / (64 * 64);
  }
  const MipMap map = make_mip_map(std::make_shared<const Texture>(t));
  ASSERT_EQ(map.levels.size(), 6u);
  std::set<std::uint16_t> values;
  for (const std::uint16_t v : map.levels[1].rgba16) values.insert(v);
  EXPECT_GT(values.size(), 60u);
  // Each level is half a step off its own mean of floats at most, whose roundings are 1e-6.
  const double half_step = 0.5 / 65535 + 1e-6;
  EXPECT_NEAR(sample_texture(map.levels[5], {0.5f, 0.5f}).x, grey, half_step);
  EXPECT_NEAR(sample_channel(map.levels[5], {0.5f, 0.5f}, 3), alpha, half_step);
}

// A square of 4 x 4 with two sets of coordinates, the second turned by a quarter.
Scene make_two_sets(const Texture& texture) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.uvs1 = {{0, 1}, {0, 0}, {1, 0}, {1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {0};
  Scene scene = test::make_scene(mesh);
  scene.textures = {std::make_shared<const Texture>(texture)};
  scene.materials[0].albedo = {1, 1, 1};
  scene.materials[0].albedo_texture = 0;
  return scene;
}

float albedo_at(const Scene& scene, float u, float v) {
  const auto prepared = PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  return test::surface_at((*prepared)->impl(), 0, u, v, {0, 0, -1}).albedo.x * 255;
}

// Corner B has u = 1, v = 0 in the first set, and (0, 0) in the second.
TEST(Texture, FollowsTheSetOfCoordinatesThatItNames) {
  Scene scene = make_two_sets(make_row({0, 80, 160, 240}));
  EXPECT_NEAR(albedo_at(scene, 0.875f, 0), 240, 1e-2);
  scene.materials[0].albedo_texture.uv_set = 1;
  EXPECT_NEAR(albedo_at(scene, 0.875f, 0), 120, 1e-2);  // v runs along x, u is 0
  scene.materials[0].albedo_texture.uv_set = 1;
  EXPECT_NEAR(albedo_at(scene, 0, 0.875f), 240, 1e-2);  // corner C has u = 1 in both
  // A mesh without that set does not show the texture.
  auto mesh = std::make_shared<Mesh>(*scene.meshes[0]);
  mesh->uvs1.clear();
  scene.meshes[0] = mesh;
  EXPECT_NEAR(albedo_at(scene, 0.875f, 0), 255, 1e-2);
}

// A texture may be scaled, turned and moved, as by KHR_texture_transform.
TEST(Texture, LiesAsItsMapSays) {
  Scene scene = make_two_sets(make_row({0, 80, 160, 240}));
  TextureRef& ref = scene.materials[0].albedo_texture;
  ref.uv_map = {2, 0, 0, 0, 1, 0};  // the picture, twice in a row
  EXPECT_NEAR(albedo_at(scene, 0.4375f, 0), 240, 1e-2);
  EXPECT_NEAR(albedo_at(scene, 0.5625f, 0), 0, 1e-2);
  ref.uv_map = {0, 1, 0, -1, 0, 1};  // a quarter turn: u of the picture is v of the mesh
  EXPECT_NEAR(albedo_at(scene, 0, 0.375f), 80, 1e-2);
  EXPECT_NEAR(albedo_at(scene, 0.5f, 0.375f), 80, 1e-2);
  ref.uv_map = {1, 0, 0.25f, 0, 1, 0};
  EXPECT_NEAR(albedo_at(scene, 0.125f, 0), 80, 1e-2);
}

// A picture that is 64 times as dense is looked up in a coarser level, here in its mean.
TEST(Texture, AMapThatShrinksThePictureChoosesCoarserLevels) {
  Scene scene = make_two_sets(make_row({0, 255, 0, 255, 0, 255, 0, 255}));
  scene.materials[0].albedo_texture.uv_map = {64, 0, 0, 0, 64, 0};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  for (const float u : {0.11f, 0.23f, 0.37f}) {
    const Surface s = test::surface_at((*prepared)->impl(), 0, u, 0.4f, {0, 0, -1}, {4 / 64.0f, 0});
    EXPECT_NEAR(s.albedo.x, 0.5f, 0.01f) << u;
  }
}

// One half of the picture is bright. A lamp that is mapped to the other half is no emitter.
TEST(Texture, LampsShowTheirPictureAsItLies) {
  Scene scene =
      make_two_sets(make_row({0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255}));
  scene.materials[0].emission = {1, 1, 1};
  TextureRef& ref = scene.materials[0].emission_texture;
  ref = 0;
  const auto emitters = [&] {
    return (*PreparedScene::build(scene, {}))->impl().lights.emitters.size();
  };
  EXPECT_EQ(emitters(), 2u);
  ref.uv_map = {0.125f, 0, 0.2f, 0, 1, 0};  // the dark half
  EXPECT_EQ(emitters(), 0u);
  ref.uv_map = {0.125f, 0, 0.7f, 0, 1, 0};
  ASSERT_EQ(emitters(), 2u);
  const auto prepared = PreparedScene::build(scene, {});
  const LightSet& lights = (*prepared)->impl().lights;
  EXPECT_NEAR(lights.emission_at(lights.emitters[0], 0.3f, 0.3f).x, 1, 1e-5f);
  ref.uv_map = {1, 0, -5, 0, 1, 0};
  auto clamped = std::make_shared<Texture>(*scene.textures[0]);
  clamped->wrap_u = TextureWrap::kClamp;
  scene.textures[0] = clamped;
  EXPECT_EQ(emitters(), 0u);
}

}  // namespace
}  // namespace tessera::core
