// SPDX-License-Identifier: Apache-2.0
#include "slave/core/surface/surface.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "slave/core/surface/surface_offset.h"
#include "slave/core/surface/texture.h"
#include "tests/support/packets.h"
#include "tests/support/plain_surface.h"
#include "tests/support/seed.h"
#include "tests/support/surface_at.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

TEST(Surface, TextureIsBilinearRepeatsAndHasRowZeroAtTheTop) {
  Texture t;
  t.width_px = t.height_px = 2;
  t.is_srgb = false;
  t.rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};
  const auto near = [](Vec3f a, Vec3f b) { return length(a - b) < 1e-6f; };
  EXPECT_TRUE(near({1, 0, 0}, sample_texture(t, {0.25f, 0.75f})));  // top left
  EXPECT_TRUE(near({0, 1, 0}, sample_texture(t, {0.75f, 0.75f})));
  EXPECT_TRUE(near({0, 0, 1}, sample_texture(t, {0.25f, 0.25f})));
  EXPECT_TRUE(near({0, 0, 1}, sample_texture(t, {-1.75f, 3.25f})));  // repeats
  EXPECT_TRUE(near({0.5f, 0.5f, 0}, sample_texture(t, {0.5f, 0.75f})));
  EXPECT_TRUE(near({0.5f, 0.5f, 0}, sample_texture(t, {0, 0.75f})));  // across the border
  t.is_srgb = true;
  t.rgba = std::vector<std::uint8_t>(16, 188);
  EXPECT_NEAR(0.5029, sample_texture(t, {0.4f, 0.1f}).x, 1e-4);  // IEC 61966-2-1
  for (const float edge : {-1e-9f, 1e-9f, 0.99999994f, 1e30f, -1e30f}) {
    EXPECT_TRUE(is_finite(sample_texture(t, {edge, edge})));
  }
}

TEST(Surface, NormalsTurnToTheViewerAndAgreeOnTheSide) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {
      {0.6f, 0, -0.8f}, {0.6f, 0, -0.8f}, {0.6f, 0, -0.8f}};  // against the geometric normal
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  Scene scene = test::make_scene(mesh);
  scene.materials[0].emission = {1, 2, 3};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  const Surface front = test::surface_at((*prepared)->impl(), 0, 0.25f, 0.25f, {0, 0, -2});
  EXPECT_EQ(1.0f, front.normal.z);
  EXPECT_NEAR(0.8f, front.shading_normal.z, 1e-6);
  EXPECT_EQ(2.0f, front.emission.y);
  const Surface back = test::surface_at((*prepared)->impl(), 0, 0.25f, 0.25f, {0, 0, 2});
  EXPECT_EQ(-1.0f, back.normal.z);
  EXPECT_NEAR(-0.8f, back.shading_normal.z, 1e-6);
  EXPECT_EQ(0.0f, back.emission.y);
}

Texture random_texture(int width, int height, bool is_srgb) {
  std::mt19937 random(test::seed(3));
  Texture t;
  t.width_px = width;
  t.height_px = height;
  t.is_srgb = is_srgb;
  for (int i = 0; i < 4 * width * height; ++i)
    t.rgba.push_back(static_cast<std::uint8_t>(random() % 256));
  return t;
}

Vec3f mean_of(const Texture& t) {
  Vec3f sum;
  for (int y = 0; y < t.height_px; ++y) {
    for (int x = 0; x < t.width_px; ++x) {
      const auto at = [](int i, int n) {
        return (static_cast<float>(i) + 0.5f) / static_cast<float>(n);
      };
      sum = sum + sample_texture(t, {at(x, t.width_px), 1 - at(y, t.height_px)});
    }
  }
  return sum * (1 / (static_cast<float>(t.width_px) * static_cast<float>(t.height_px)));
}

TEST(Surface, MipLevelsHalveTheSidesAndKeepTheMeanOfLinearLight) {
  for (const bool is_srgb : {false, true}) {
    for (const auto& [width, height] : {std::pair{64, 64}, {37, 11}, {1, 5}, {1, 1}}) {
      const Texture base = random_texture(width, height, is_srgb);
      const MipMap map = make_mip_map(std::make_shared<const Texture>(base));
      const Vec3f mean = mean_of(base);
      int w = width, h = height;
      for (const Texture& level : map.levels) {
        w = std::max(1, w / 2);
        h = std::max(1, h / 2);
        EXPECT_EQ(level.width_px, w);
        EXPECT_EQ(level.height_px, h);
        // Half a step of a byte; steps of sRGB are up to 2.3 / 255 of linear light.
        EXPECT_LT(length(mean_of(level) - mean), 2.3f / 255) << width << "x" << height;
      }
      EXPECT_TRUE(w == 1 && h == 1);
    }
  }
}

// Tests the plain reference; core_surfaces_test shows that the kernels agree with it.
TEST(Surface, FootprintsChooseBetweenLevelsAndNothingIsTooWide) {
  const MipMap map = make_mip_map(std::make_shared<const Texture>(random_texture(8, 8, false)));
  const Vec2f uv{0.3f, 0.6f};
  for (const float texels : {0.0f, 0.5f, 1.0f})
    EXPECT_EQ(test::plain_mip_map_sample(map, uv, texels), sample_texture(*map.base, uv));
  const Vec3f one = sample_texture(map.levels[0], uv), two = sample_texture(map.levels[1], uv);
  EXPECT_EQ(test::plain_mip_map_sample(map, uv, 2), one);
  EXPECT_EQ(test::plain_mip_map_sample(map, uv, 4), two);
  EXPECT_LT(length(test::plain_mip_map_sample(map, uv, 3) - (one + two) * 0.5f), 1e-6f);
  EXPECT_LT(length(test::plain_mip_map_sample(map, uv, 1.00001f) - sample_texture(*map.base, uv)),
            1e-4f);
  const float inf = std::numeric_limits<float>::infinity();
  for (const float texels : {8.0f, 1e30f, inf, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(test::plain_mip_map_sample(map, uv, texels), sample_texture(map.levels[2], uv));
}

TEST(Surface, HugeAndWrongTextureCoordinatesAreSomeTexel) {
  const Texture texture = random_texture(1000, 3, false);
  const float huge = 3.4028234e38f, inf = std::numeric_limits<float>::infinity();
  for (const float x : {huge, -huge, inf, -inf, std::numeric_limits<float>::quiet_NaN(), 1e9f}) {
    for (const Vec2f uv : {Vec2f{x, 0.5f}, Vec2f{0.5f, x}, Vec2f{x, x}})
      EXPECT_TRUE(is_finite(sample_texture(texture, uv))) << uv.x << " " << uv.y;
  }
}

// A cone as wide as the whole image sees its mean; one that is a texel wide sees the texel.
TEST(Surface, TexturesAreLookedUpInTheLevelOfTheCone) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  Scene scene = test::make_scene(mesh);
  scene.materials[0].albedo = {1, 1, 1};
  scene.materials[0].albedo_texture = 0;
  scene.textures = {std::make_shared<const Texture>(random_texture(64, 64, false))};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  const auto albedo = [&](Vec3f direction, float width) {
    return test::surface_at((*prepared)->impl(), 0, 0.3f, 0.4f, direction, {width, 0}).albedo;
  };
  const MipMap& map = *(*prepared)->impl().textures[0];
  const Vec2f uv{0.3f, 0.4f};
  EXPECT_LT(length(albedo({0, 0, -1}, 0) - sample_texture(*map.base, uv)), 1e-4f);
  EXPECT_LT(length(albedo({0, 0, -1}, 4 / 64.0f) - sample_texture(*map.base, uv)), 1e-4f);
  EXPECT_LT(length(albedo({0, 0, -1}, 1) - sample_texture(map.levels[3], uv)), 1e-5f);
  EXPECT_LT(length(albedo({0, 0, -1}, 4) - sample_texture(map.levels[5], uv)), 1e-5f);
  // At 60 degrees the footprint is twice as wide; the length of the direction does not count.
  EXPECT_LT(length(albedo({0, 1.7320508f, -1}, 0.5f) - albedo({0, 0, -5}, 1)), 1e-4f);
}

// Vertex normals that equal the normals of the triangles cost nothing.
TEST(Surface, FlatNormalsAreNoFeature) {
  Mesh mesh = test::make_cube();
  Mesh flat;
  for (const auto& t : mesh.triangles) {
    const auto n = static_cast<std::uint32_t>(flat.positions.size());
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    flat.positions.insert(flat.positions.end(), {a, b, c});
    flat.normals.insert(flat.normals.end(), 3, normalize(cross(b - a, c - a)));
    flat.triangles.push_back({n, n + 1, n + 2});
  }
  flat.materials = {0};
  const auto has_normals = [](const Mesh& m) {
    return bool{(*PreparedScene::build(test::make_scene(m), {}))->impl().features.has_normals};
  };
  EXPECT_FALSE(has_normals(flat));
  flat.normals[4] = normalize(flat.normals[4] + Vec3f{1e-4f, 2e-4f, 1e-4f});
  EXPECT_TRUE(has_normals(flat));
}

// A triangle in the plane z = 0, u along x, v along y or, mirrored, against it.
Scene make_normal_mapped(bool is_mirrored, std::array<std::uint8_t, 3> texel) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {0, is_mirrored ? -1.0f : 1.0f}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  Scene scene = test::make_scene(mesh);
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = 1;
  texture->is_srgb = false;
  texture->rgba = {texel[0], texel[1], texel[2], 255};
  scene.textures = {texture};
  scene.materials[0].normal_texture = 0;
  return scene;
}

Vec3f shading_normal(const Scene& scene, Vec3f direction) {
  const auto prepared = PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  return test::surface_at((*prepared)->impl(), 0, 0.3f, 0.4f, direction).shading_normal;
}

// In a normal map 255 is 1, 128 is 1/255 and 0 is -1.
TEST(Surface, NormalMapsTurnTheNormalAlongUAndV) {
  const float step = 2 / 255.0f;
  const Vec3f down{0, 0, -1}, up{0, 0, 1};
  const auto expect_near = [](Vec3f a, Vec3f b) {
    EXPECT_LT(length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z;
  };
  for (const bool is_mirrored : {false, true}) {
    const float v = is_mirrored ? -1.0f : 1.0f;
    Scene scene = make_normal_mapped(is_mirrored, {228, 178, 255});
    const Vec3f turned = normalize({228 * step - 1, v * (178 * step - 1), 1});
    expect_near(shading_normal(scene, down), turned);
    expect_near(shading_normal(scene, up), -turned);
    scene.materials[0].normal_scale = 0.5f;
    expect_near(shading_normal(scene, down),
                normalize({(228 * step - 1) / 2, v * (178 * step - 1) / 2, 1}));
    scene.materials[0].normal_scale = 0;
    expect_near(shading_normal(scene, down), {0, 0, 1});
  }
  // A normal that points behind the surface, and texture coordinates without area, leave the
  // shading normal as it was.
  expect_near(shading_normal(make_normal_mapped(false, {255, 128, 0}), down), {0, 0, 1});
  Scene flat = make_normal_mapped(false, {228, 178, 255});
  auto mesh = std::make_shared<Mesh>(*flat.meshes[0]);
  mesh->uvs.assign(3, {0.5f, 0.5f});
  flat.meshes[0] = mesh;
  expect_near(shading_normal(flat, down), {0, 0, 1});
}

TEST(Surface, NormalMapsTurnWithTheObject) {
  Scene scene = make_normal_mapped(false, {255, 128, 255});
  scene.instances[0].object_to_world.m = {
      {{0, 0, 3, 1}, {2, 0, 0, 2}, {0, 5, 0, 3}}};  // x to y, y to z, z to x
  const Vec3f n = shading_normal(scene, {-1, 0, 0});
  EXPECT_NEAR(n.x, std::sqrt(0.5f), 0.01f);
  EXPECT_NEAR(n.y, std::sqrt(0.5f), 0.01f);
  EXPECT_NEAR(n.z, 0, 0.01f);
}

// The offset of surface_offset.h puts a start beyond the exact plane, which is computed in double.
TEST(Surface, OffsetPointLiesBeyondTheExactPlane) {
  std::mt19937 random(test::seed(7));
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    const float scale = std::ldexp(1.0f, static_cast<int>(random() % 40) - 20);
    const float away = random() % 2 ? scale * 1000 : 0;
    const auto any = [&] { return Vec3f{unit(random), unit(random), unit(random)}; };
    const Vec3f a = any() * scale + Vec3f{away, away, -away}, b = a + any() * scale,
                c = a + any() * scale;
    const Vec3f e1 = b - a, e2 = c - a, cr = cross(e1, e2);
    if (!(length(cr) > 0.01f * scale * scale)) continue;
    const Vec3f n = normalize(cr);
    const float u = (unit(random) + 1) / 4, v = (unit(random) + 1) / 4;
    const SurfacePoint at = surface_point(a, e1, e2, n, u, v);
    const Vec3f start = at.point + n * at.offset;
    const double e[3] = {double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
    const double f[3] = {double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
    const double m[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2],
                         e[0] * f[1] - e[1] * f[0]};
    const double height = m[0] * (double{start.x} - a.x) + m[1] * (double{start.y} - a.y) +
                          m[2] * (double{start.z} - a.z);
    ASSERT_GT(height, 0) << "round " << i << " scale " << scale;
  }
}

}  // namespace
}  // namespace tessera::core
