#include "slave/core/render/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "slave/core/geometry/surface_offset.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

TEST(Surface, TextureIsBilinearRepeatsAndHasRowZeroAtTheTop) {
  Texture t{2, 2, false, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}};
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
      {0.6f, 0, -0.8f}, {0.6f, 0, -0.8f}, {0.6f, 0, -0.8f}};  // against the geometric one
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  Scene scene = test::make_scene(mesh);
  scene.materials[0].emission = {1, 2, 3};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  const Surface front = surface_at((*prepared)->impl(), 0, 0.25f, 0.25f, {0, 0, -2});
  EXPECT_EQ(1.0f, front.normal.z);
  EXPECT_NEAR(0.8f, front.shading_normal.z, 1e-6);
  EXPECT_EQ(2.0f, front.emission.y);
  const Surface back = surface_at((*prepared)->impl(), 0, 0.25f, 0.25f, {0, 0, 2});
  EXPECT_EQ(-1.0f, back.normal.z);
  EXPECT_NEAR(-0.8f, back.shading_normal.z, 1e-6);
  EXPECT_EQ(0.0f, back.emission.y);
}

// The bound of surface_offset.h against the exact plane, in double.
TEST(Surface, OffsetPointLiesBeyondTheExactPlane) {
  std::mt19937 random(7);
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
