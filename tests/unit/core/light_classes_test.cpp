// SPDX-License-Identifier: Apache-2.0
// Path tracer and instant global illumination against closed forms, for classes of light that are
// hard for one of them: form factors, a lamp that shares an edge with what it lights, light that
// comes only over other surfaces.
#include <gtest/gtest.h>

#include <cmath>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

double mean_of(const Scene& scene, FrameSettings settings) {
  double sum = 0;
  const std::uint32_t seeds = settings.renderer == Renderer::kIgi ? 8 : 1;
  for (settings.seed = 0; settings.seed < seeds; ++settings.seed) {
    const std::vector<float> rgb = test::render(scene, settings);
    for (const float x : rgb) sum += x / static_cast<double>(rgb.size()) / seeds;
  }
  return sum;
}

// Settings of a camera between the squares that sees the unit square on the floor and nothing else,
// an equal part of it in each pixel.
FrameSettings settings_of(Renderer renderer, int samples) {
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.camera = {{0.5f, 0.5f, 0.5f}, {0.5f, 0, 0.5f}, {0, 0, -1}, 90};
  settings.renderer = renderer;
  settings.samples_per_pixel = samples;
  settings.bounces = 0;
  settings.vpls = 256;
  settings.clamp = kClampAuto;
  settings.is_compensated = true;
  return settings;
}

constexpr Renderer kRenderers[] = {Renderer::kPath, Renderer::kIgi};

// A white unit square on the floor, and a lamp of radiance 1.
Scene make_floor_and_lamp(Vec3f corner, Vec3f b, Vec3f c) {
  Mesh mesh;
  mesh.materials.clear();
  test::add_quad(mesh, {0, 0, 1}, {1, 0, 0}, {0, 0, -1}, 0);
  test::add_quad(mesh, corner, b, c, 1);
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[0].albedo = {1, 1, 1};
  scene.materials[1].albedo = {0, 0, 0};
  scene.materials[1].emission = {1, 1, 1};
  return scene;
}

// Puts a picture before the lamp. Texels for which is_bright(x, y) holds are white, the others
// black; row 0 is on top.
template <class IsBright>
void cover_lamp(Scene& scene, int width_px, int height_px, IsBright is_bright) {
  auto picture = std::make_shared<Texture>();
  picture->width_px = width_px;
  picture->height_px = height_px;
  for (int i = 0; i < width_px * height_px; ++i) {
    const std::uint8_t texel = is_bright(i % width_px, i / width_px) ? 255 : 0;
    picture->rgba.insert(picture->rgba.end(), {texel, texel, texel, 255});
  }
  scene.textures = {picture};
  scene.materials[1].emission_texture = 0;
}

// Maps the whole picture onto the lamp of make_floor_and_lamp().
void show_whole_picture(Scene& scene) {
  auto mesh = std::make_shared<Mesh>(*scene.meshes[0]);
  mesh->uvs.assign(4, {0, 0});
  mesh->uvs.insert(mesh->uvs.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  scene.meshes[0] = mesh;
}

// A lamp of which a picture covers one half lights as one of half its size does. Light samples are
// shared out among triangles by the mean of the picture over each.
TEST(LightClasses, AHalfCoveredLampIsOneOfHalfTheSize) {
  Scene covered = make_floor_and_lamp({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  show_whole_picture(covered);
  cover_lamp(covered, 512, 2,
             [](int x, int) { return x < 128 || x >= 384; });  // the blurred edge is narrow
  Scene halves = make_floor_and_lamp({0, 1, 0}, {0.25f, 0, 0}, {0, 0, 1});
  auto two = std::make_shared<Mesh>(*halves.meshes[0]);
  test::add_quad(*two, {0.75f, 1, 0}, {0.25f, 0, 0}, {0, 0, 1}, 1);
  halves.meshes[0] = two;
  for (Scene* scene : {&covered, &halves}) {
    scene->materials[0].bsdf = BsdfKind::kGlossy;  // rays of the BSDF find the lamp, too
    scene->materials[0].roughness = 0.5f;
  }
  for (const Renderer renderer : kRenderers) {
    const double expected = mean_of(halves, settings_of(renderer, 64));
    EXPECT_NEAR(mean_of(covered, settings_of(renderer, 64)), expected, 0.01 * expected)
        << renderer_name(renderer);
  }
  for (Scene* scene : {&covered, &halves}) scene->materials[0].bsdf = BsdfKind::kDiffuse;
  for (const Renderer renderer : kRenderers) {
    const double expected = mean_of(halves, settings_of(renderer, 64));
    EXPECT_NEAR(mean_of(covered, settings_of(renderer, 64)), expected, 0.01 * expected)
        << renderer_name(renderer) << " diffuse";
  }
}

// Triangles of a lamp that a picture leaves dark take no light samples and shed no light.
TEST(LightClasses, DarkPartsOfAPictureAreNoEmitters) {
  Scene scene = make_floor_and_lamp({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  auto mesh = std::make_shared<Mesh>(*scene.meshes[0]);
  for (int i = 0; i < 100; ++i)
    test::add_quad(*mesh, {2.0f + static_cast<float>(i), 1, 0}, {1, 0, 0}, {0, 0, 1}, 1);
  mesh->uvs.assign(mesh->positions.size(), {0.5f, 0.75f});
  for (std::size_t i = 4; i < 8; ++i) mesh->uvs[i] = {0.5f, 0.25f};
  scene.meshes[0] = mesh;
  cover_lamp(scene, 64, 64, [](int, int y) { return y >= 32; });
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  EXPECT_EQ((*prepared)->impl().lights.emitters.size(), 2u);
}

// An atlas: cells of a lamp show the bright or the dark half of one picture, and nothing of the
// other half may bleed into them, whichever way light is found.
TEST(LightClasses, ALampOfAnAtlasIsOneOfItsBrightCells) {
  Scene atlas = make_floor_and_lamp({0, 5, 0}, {0.01f, 0, 0}, {0, 0, 0.01f});
  Scene plain = atlas;
  auto with_uvs = std::make_shared<Mesh>(*atlas.meshes[0]);
  auto by_material = std::make_shared<Mesh>(*plain.meshes[0]);
  with_uvs->uvs.assign(with_uvs->positions.size(), {0.25f, 0.1f});
  constexpr int kCells = 8;
  for (int i = 0; i < kCells * kCells; ++i) {
    const bool is_bright = (i % kCells + i / kCells) % 2 == 0;
    const Vec3f at{static_cast<float>(i % kCells) / kCells, 1,
                   static_cast<float>(i / kCells) / kCells};
    const Vec3f x{1.0f / kCells, 0, 0}, z{0, 0, 1.0f / kCells};
    test::add_quad(*with_uvs, at, x, z, 1);
    test::add_quad(*by_material, at, x, z, is_bright ? 1 : 0);
    const float u = is_bright ? 0.55f : 0.05f;  // the left half of the picture is dark
    with_uvs->uvs.insert(with_uvs->uvs.end(),
                         {{u, 0.1f}, {u + 0.4f, 0.1f}, {u + 0.4f, 0.9f}, {u, 0.9f}});
  }
  atlas.meshes[0] = with_uvs;
  plain.meshes[0] = by_material;
  cover_lamp(atlas, 64, 64, [](int x, int) { return x >= 32; });
  for (Scene* scene : {&atlas, &plain}) {
    scene->materials[0].bsdf = BsdfKind::kGlossy;
    scene->materials[0].roughness = 0.5f;
  }
  for (const Renderer renderer : {Renderer::kPath, Renderer::kDirect}) {
    const double expected = mean_of(plain, settings_of(renderer, 64));
    EXPECT_NEAR(mean_of(atlas, settings_of(renderer, 64)), expected, 0.01 * expected)
        << renderer_name(renderer);
  }
}

// A spot so small that it rounds to nothing in the picture's mip levels is a lamp all the same.
TEST(LightClasses, ASmallSpotOfAPictureIsALamp) {
  Scene scene = make_floor_and_lamp({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  show_whole_picture(scene);
  cover_lamp(scene, 512, 512, [](int x, int y) { return x == 100 && y == 256; });
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  EXPECT_EQ((*prepared)->impl().lights.emitters.size(), 2u);
}

// Form factors between unit squares that face each other at distance 1 and, in the test below, that
// stand on a common edge: Howell, "A catalog of radiation heat transfer configuration factors",
// C-11 and C-14.
TEST(LightClasses, FacingSquaresHaveTheirFormFactor) {
  const double x = 1, u = std::sqrt(1 + x * x);
  const double factor = 2 / (3.14159265358979 * x * x) *
                        (std::log((1 + x * x) / std::sqrt(1 + 2 * x * x)) +
                         2 * x * u * std::atan(x / u) - 2 * x * std::atan(x));
  ASSERT_NEAR(factor, 0.199825, 1e-6);
  const Scene scene = make_floor_and_lamp({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  for (const Renderer renderer : kRenderers)
    EXPECT_NEAR(mean_of(scene, settings_of(renderer, 64)), factor, 0.003 * factor)
        << renderer_name(renderer);
}

// The lamp ends where the floor begins, so that floor and lamp come as near as one likes.
TEST(LightClasses, SquaresOnACommonEdgeHaveTheirFormFactor) {
  const double factor = 0.200043776;
  const Scene scene = make_floor_and_lamp({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const Renderer renderer : kRenderers)
    EXPECT_NEAR(mean_of(scene, settings_of(renderer, 64)), factor, 0.01 * factor)
        << renderer_name(renderer);
}

// Within a sphere every patch lights every point alike, by its share f of the whole. After k
// surfaces of albedo a the radiance is L f (a + ... + a^k), without the lamp itself.
TEST(LightClasses, ALampOnASphereIsAGeometricSeries) {
  Mesh mesh = test::make_icosphere(4);
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // the faces look inwards
  mesh.materials.assign(mesh.triangles.size(), 0);
  double lamp = 0, whole = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const double area = length(cross(b - a, c - a));
    whole += area;
    if (a.z + b.z + c.z < 2.4f) continue;
    lamp += area;
    mesh.materials[i] = 1;
  }
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  const float albedo = 0.6f;
  for (Material& m : scene.materials) m.albedo = {albedo, albedo, albedo};
  scene.materials[1].emission = {10, 10, 10};
  for (const int bounces : {0, 1, 3}) {
    double expected = 0;
    for (int k = 1; k <= bounces + 1; ++k) expected += std::pow(albedo, k);
    expected *= 10 * lamp / whole;
    for (const Renderer renderer : kRenderers) {
      FrameSettings settings = settings_of(renderer, 64);
      settings.camera = {{0, 0, 0.2f}, {0.1f, 0.2f, -1}, {0, 1, 0}, 80};  // away from the lamp
      settings.bounces = bounces;
      EXPECT_NEAR(mean_of(scene, settings), expected, 0.01 * expected)
          << renderer_name(renderer) << " " << bounces;
    }
  }
}

// A lamp under the ceiling shines up and lights nothing else of the room, so that all light on the
// floor has come over the ceiling.
TEST(LightClasses, ARoomThatIsLitByItsCeilingAlone) {
  Mesh mesh;
  mesh.materials.clear();
  const auto add_box_from_within = [&](Vec3f at, Vec3f size) {
    const Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
    test::add_quad(mesh, at, z, x, 0);
    test::add_quad(mesh, at + y, x, z, 0);
    test::add_quad(mesh, at, x, y, 0);
    test::add_quad(mesh, at + z, y, x, 0);
    test::add_quad(mesh, at, y, z, 0);
    test::add_quad(mesh, at + x, z, y, 0);
  };
  add_box_from_within({0, 0, 0}, {2, 2, 2});
  test::add_quad(mesh, {0.6f, 1.8f, 0.6f}, {0, 0, 0.8f}, {0.8f, 0, 0}, 1);
  Scene scene = test::make_scene(std::move(mesh));
  scene.materials.resize(2);
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.materials[1].albedo = {0, 0, 0};
  scene.materials[1].emission = {20, 20, 20};
  const auto seen = [&](Renderer renderer, int bounces) {
    FrameSettings settings = settings_of(renderer, renderer == Renderer::kPath ? 1024 : 16);
    settings.camera = {{1, 0.9f, 1.8f}, {1, 0, 1}, {0, 1, 0}, 60};
    settings.bounces = bounces;
    return mean_of(scene, settings);
  };
  EXPECT_EQ(seen(Renderer::kPath, 0), 0);
  EXPECT_EQ(seen(Renderer::kIgi, 0), 0);
  for (const int bounces : {1, 3}) {
    const double path = seen(Renderer::kPath, bounces);
    EXPECT_GT(path, 0.05);
    EXPECT_NEAR(seen(Renderer::kIgi, bounces), path, 0.01 * path) << bounces;
  }
}

}  // namespace
}  // namespace tessera::core
