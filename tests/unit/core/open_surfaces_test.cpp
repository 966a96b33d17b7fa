// SPDX-License-Identifier: Apache-2.0
// Surfaces with masks or blending, vertex colours, unlit surfaces, and lamps with two sides.
#include <gtest/gtest.h>

#include <cmath>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using test::render;

constexpr int kSide = 32;

// A square at height y, [-half, half]^2, that looks up, with texture coordinates 0 to 1.
void add_square(Mesh& mesh, float y, float half, std::uint32_t material) {
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(),
                        {{-half, y, half}, {half, y, half}, {half, y, -half}, {-half, y, -half}});
  mesh.uvs.insert(mesh.uvs.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  mesh.triangles.push_back({n, n + 1, n + 2});
  mesh.triangles.push_back({n, n + 2, n + 3});
  mesh.materials.insert(mesh.materials.end(), 2, material);
}

// A floor at height 0 with cards above it. The camera sees [-1, 1]^2 of it from straight above.
struct Cards {
  Mesh mesh;
  Scene scene;
  FrameSettings settings;

  Cards() {
    add_square(mesh, 0, 3, 0);
    settings.width_px = settings.height_px = kSide;
    settings.camera = {{0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 53.130102f};
    scene.materials.resize(2);
    for (Material& m : scene.materials) m.albedo = {0.5f, 0.5f, 0.5f};
    scene.lights.push_back({LightKind::kDirectional, {}, {0, -1, 0}, {1, 1, 1}, 1, 0});
  }
  Material& card(float y, float half) {
    add_square(mesh, y, half, 1);
    return scene.materials[1];
  }
  Scene made() const {
    Scene made = scene;
    made.meshes = {std::make_shared<Mesh>(mesh)};
    made.instances.resize(1);
    return made;
  }
  std::vector<float> picture() const { return render(made(), settings); }
};

float at(const std::vector<float>& rgb, int x, int y, std::size_t channel = 0) {
  return rgb[3 * static_cast<std::size_t>(y * kSide + x) + channel];
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

// A texture of four quarters, two opaque and two transparent, crosswise.
std::shared_ptr<Texture> crosswise() {
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = 2;
  texture->is_nearest = true;
  texture->wrap_u = texture->wrap_v = TextureWrap::kClamp;
  for (const auto alpha : std::initializer_list<std::uint8_t>{255, 0, 0, 255})
    texture->rgba.insert(texture->rgba.end(), {255, 255, 255, alpha});
  return texture;
}

TEST(OpenSurfaces, RaysGoThroughTheHolesOfAMaskAndNoWhereElse) {
  Cards cards;
  cards.card(1, 0.5f).alpha = {AlphaMode::kMask, 1, 0.5f, 0, 3};
  cards.scene.textures = {crosswise()};
  cards.settings.renderer = Renderer::kPrimary;
  const std::vector<float> rgb = cards.picture();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double px = (x + 0.5) / 16 - 1, pz = (y + 0.5) / 16 - 1;
      // The card fills the picture; row 0 of the texture is its far edge, at the top.
      const bool is_there = (px < 0) == (pz < 0);
      const double to_floor = std::sqrt(4 + px * px + pz * pz);
      EXPECT_NEAR(is_there ? to_floor / 2 : to_floor, at(rgb, x, y), 1e-5) << x << " " << y;
    }
  }
}

TEST(OpenSurfaces, LightFallsThroughTheHolesOfAMask) {
  Cards cards;
  cards.card(1, 0.25f).alpha = {AlphaMode::kMask, 1, 0.5f, 0, 3};
  cards.scene.textures = {crosswise()};
  // The camera is below the card and sees the floor alone. In directional light the shadow is as
  // large as the card.
  cards.settings.camera = {{0, 0.9f, 0}, {0, 0, 0}, {0, 0, -1}, 53.130102f};
  const std::vector<float> rgb = cards.picture();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double px = ((x + 0.5) / 16 - 1) * 0.45, pz = ((y + 0.5) / 16 - 1) * 0.45;
      const bool is_below = std::fabs(px) < 0.25 && std::fabs(pz) < 0.25;
      const bool is_dark = is_below && (px < 0) == (pz < 0);
      EXPECT_NEAR(is_dark ? 0 : 0.5 / 3.14159265, at(rgb, x, y), 1e-6) << x << " " << y;
    }
  }
}

// Two sheets of opacity 1/4 let 0.75^2 of the light through in every renderer. The standard
// deviation of the mean of 16,384 samples is 0.004 of it.
TEST(OpenSurfaces, ABlendedSheetLetsThroughTheRestOfItsOpacity) {
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    Cards cards;
    cards.card(1, 8).alpha = {AlphaMode::kBlend, 0.25f, 0.5f, {}, 3};
    cards.card(1.5f, 8);
    cards.scene.materials[1].albedo = {};  // light that a sheet stops is lost
    cards.settings.camera.eye.y = 0.9f;
    cards.settings.renderer = renderer;
    cards.settings.bounces = 0;
    cards.settings.samples_per_pixel = 16;
    EXPECT_NEAR(1, mean(cards.picture()) / (0.5 / 3.14159265 * 0.5625), 0.02)
        << renderer_name(renderer);
    cards.settings.camera.eye.y = 2;  // now the camera looks through both, too
    EXPECT_NEAR(1, mean(cards.picture()) / (0.5 / 3.14159265 * 0.5625 * 0.5625), 0.03)
        << renderer_name(renderer);
  }
}

TEST(OpenSurfaces, TheirBitsAreTheSameEverywhere) {
  Cards cards;
  cards.card(0.5f, 0.6f).alpha = {AlphaMode::kBlend, 0.4f, 0.5f, 0, 3};
  cards.scene.textures = {crosswise()};
  cards.scene.environment = {0.3f, 0.2f, 0.1f};
  cards.settings.renderer = Renderer::kPath;
  const auto prepared = PreparedScene::build(cards.made(), {});
  ASSERT_TRUE(prepared.is_ok());
  const std::vector<float> one = render(cards.made(), cards.settings);
  for (const Isa isa : {Isa::kScalar, Isa::kSse4, Isa::kAvx2, Isa::kAvx512}) {
    if ((supported_isas() & isa_bit(isa)) == 0) continue;
    for (const int edge : {8, 16, 32}) {
      EXPECT_TRUE(
          test::same_bits(one, test::render_in_tiles(**prepared, cards.settings, isa, edge)))
          << isa_name(isa) << " " << edge;
    }
  }
}

TEST(OpenSurfaces, OpaquePicturesCostNothing) {
  Cards cards;
  cards.card(1, 0.5f).alpha = {AlphaMode::kBlend, 1, 0.5f, 0, 3};
  auto full = crosswise();
  for (std::size_t i = 3; i < 16; i += 4) full->rgba[i] = 255;
  cards.scene.textures = {full};
  const auto prepared = PreparedScene::build(cards.made(), {});
  ASSERT_TRUE(prepared.is_ok());
  EXPECT_EQ((*prepared)->impl().alpha, nullptr);
}

TEST(OpenSurfaces, ColorsOfVerticesMultiply) {
  Cards cards;
  cards.mesh.colors = {{0, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 1, 1}, {0, 0, 1, 1}};  // x red, far blue
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    cards.settings.renderer = renderer;
    cards.settings.bounces = 0;
    const std::vector<float> rgb = cards.picture();
    const double full = 0.5 / 3.14159265;
    for (const int x : {0, 7, 16, 31}) {
      const double px = (x + 0.5) / 16 - 1;
      EXPECT_NEAR(full * (px + 3) / 6, at(rgb, x, 16), 1e-6) << renderer_name(renderer);
      EXPECT_NEAR(0, at(rgb, x, 16, 1), 1e-6);
      EXPECT_NEAR(full * (3 - px) / 6, at(rgb, 16, x, 2), 1e-6) << renderer_name(renderer);
    }
  }
}

TEST(OpenSurfaces, WhatIsNotLitShowsItsColorToTheCameraAlone) {
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    Cards cards;
    cards.card(0.5f, 0.25f).is_unlit = true;
    cards.scene.materials[1].albedo = {0.9f, 0.6f, 0.3f};
    cards.settings.renderer = renderer;
    const std::vector<float> rgb = cards.picture();
    EXPECT_FLOAT_EQ(0.9f, at(rgb, 16, 16)) << renderer_name(renderer);
    EXPECT_FLOAT_EQ(0.3f, at(rgb, 16, 16, 2)) << renderer_name(renderer);
    // The floor beside the card is as it would be without the card.
    EXPECT_NEAR(0.5 / 3.14159265, at(rgb, 2, 2), 1e-6) << renderer_name(renderer);
    EXPECT_FLOAT_EQ(at(rgb, 2, 2), at(rgb, 2, 2, 2)) << renderer_name(renderer);
    cards.scene.materials[0].bsdf = BsdfKind::kMirror;
    cards.scene.materials[0].specular = {1, 1, 1};
    cards.mesh = {};
    add_square(cards.mesh, 0, 3, 0);
    add_square(cards.mesh, 3, 4, 1);  // behind the camera, seen in the mirror
    const std::vector<float> mirrored = cards.picture();
    EXPECT_NEAR(0.6f, at(mirrored, 16, 16, 1), 1e-6) << renderer_name(renderer);
  }
}

TEST(OpenSurfaces, ALampOfTwoSidesLightsBoth) {
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath}) {
    Cards cards;
    cards.scene.lights.clear();
    Material& lamp = cards.card(1, 0.5f);  // looks up, away from the floor
    lamp.emission = {1, 1, 1};
    lamp.albedo = {};
    cards.settings.camera.eye.y = 0.9f;
    cards.settings.renderer = renderer;
    cards.settings.bounces = 0;
    cards.settings.samples_per_pixel = 64;
    EXPECT_EQ(0, mean(cards.picture())) << "one side";
    lamp.is_double_sided = true;
    const double both = mean(cards.picture());
    lamp.is_double_sided = false;
    for (auto& t : cards.mesh.triangles) {
      if (t[0] >= 4) std::swap(t[1], t[2]);  // turned to look down
    }
    EXPECT_NEAR(1, both / mean(cards.picture()), 0.01) << renderer_name(renderer);
  }
}

// What a lamp sheds is proportional to its opacity, whether it is found by light samples (direct,
// on diffuse surfaces), by BSDF samples or by both. The lamp is near and large, so BSDF samples
// carry most of the light on a glossy floor; the standard deviation of the mean is below 0.005 of
// it.
TEST(OpenSurfaces, ABlendedLampShedsTheShareOfItsOpacity) {
  for (const bool is_glossy : {false, true}) {
    for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath}) {
      Cards cards;
      cards.scene.lights.clear();
      Material& lamp = cards.card(1, 1);
      lamp.emission = {1, 1, 1};
      lamp.albedo = {};
      for (auto& t : cards.mesh.triangles) {
        if (t[0] >= 4) std::swap(t[1], t[2]);  // turned to look down
      }
      if (is_glossy) {
        cards.scene.materials[0].bsdf = BsdfKind::kGlossy;
        cards.scene.materials[0].roughness = 0.3f;
        cards.scene.materials[0].metalness = 1;
      }
      cards.settings.camera.eye.y = 0.9f;
      cards.settings.renderer = renderer;
      cards.settings.bounces = 0;
      cards.settings.samples_per_pixel = 64;
      const double opaque = mean(cards.picture());
      lamp.alpha = {AlphaMode::kBlend, 0.25f, 0.5f, {}, 3};
      EXPECT_NEAR(0.25, mean(cards.picture()) / opaque, 0.005)
          << renderer_name(renderer) << (is_glossy ? ", glossy" : "");
    }
  }
}

}  // namespace
}  // namespace tessera::core
