// SPDX-License-Identifier: Apache-2.0
// Planes of a picture hold what is known of a square, and have the same bits whatever tiles and
// instruction set are used.
#include "slave/core/integrate/planes/plane_tile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/packets.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Values of all planes of a picture, by plane: [pixel][channel].
using Planes = std::array<std::vector<float>, kPlaneRows.size()>;

Planes planes_of(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                 int edge_px = 256, RayCounts* counts = nullptr) {
  const auto width = static_cast<std::size_t>(settings.width_px);
  Planes picture;
  settings.planes.for_each([&](Plane plane) {
    picture[static_cast<std::size_t>(plane)].resize(
        width * static_cast<std::size_t>(settings.height_px) * plane_row(plane).channel_count());
  });
  PlaneTile tile;
  const TileGrid grid(settings.width_px, settings.height_px, edge_px);
  for (TileIndex i = grid.tile_count(); i-- > 0;) {
    const TileRect rect = grid.rect(i);
    const auto pixels = static_cast<std::size_t>(rect.pixel_count());
    std::vector<float> values(pixels * channel_count(settings.planes), -1.0f);
    const RayCounts rays = tile.render(scene, settings, isa, rect, values);
    if (counts != nullptr) *counts += rays;
    std::size_t before = 0;
    settings.planes.for_each([&](Plane plane) {
      const std::size_t channels = plane_row(plane).channel_count();
      for (std::size_t p = 0; p < pixels; ++p) {
        const auto x =
            static_cast<std::size_t>(rect.x_px) + p % static_cast<std::size_t>(rect.width_px);
        const auto y =
            static_cast<std::size_t>(rect.y_px) + p / static_cast<std::size_t>(rect.width_px);
        for (std::size_t c = 0; c < channels; ++c)
          picture[static_cast<std::size_t>(plane)][(y * width + x) * channels + c] =
              values[before + p * channels + c];
      }
      before += pixels * channels;
    });
  }
  return picture;
}

Planes planes_of(const Scene& scene, const FrameSettings& settings) {
  const auto prepared = PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  return planes_of(**prepared, settings, widest_isa(supported_isas()));
}

const std::vector<float>& of(const Planes& planes, Plane plane) {
  return planes[static_cast<std::size_t>(plane)];
}

FrameSettings settings_of(int samples) {
  FrameSettings settings;
  settings.width_px = 83;
  settings.height_px = 61;
  settings.camera = {{0.3f, 1.4f, 2.5f}, {0, 0.1f, 0}, {0, 1, 0}, 50};
  settings.samples_per_pixel = samples;
  settings.seed = 5;
  settings.planes = PlaneSet::all();
  return settings;
}

TEST(PlaneTile, BitsDependNeitherOnTilesNorOnTheInstructionSet) {
  for (const Scene& scene : {test::make_full_scene(), test::make_scene_of_all_materials()}) {
    const auto prepared = PreparedScene::build(scene, {});
    ASSERT_TRUE(prepared.is_ok());
    for (const int samples : {1, 3}) {
      const FrameSettings settings = settings_of(samples);
      RayCounts whole_counts;
      const Planes whole = planes_of(**prepared, settings, Isa::kScalar, 256, &whole_counts);
      EXPECT_EQ(whole_counts.primary, 83u * 61u * static_cast<unsigned>(samples));
      for (const Isa isa : test::isas_here()) {
        for (const int edge_px : {32, 40, 7}) {
          RayCounts counts;
          const Planes cut = planes_of(**prepared, settings, isa, edge_px, &counts);
          EXPECT_TRUE(counts == whole_counts);
          settings.planes.for_each([&](Plane plane) {
            EXPECT_TRUE(test::same_bits(of(whole, plane), of(cut, plane)))
                << plane_row(plane).name << " " << isa_name(isa) << " tile " << edge_px;
          });
        }
      }
    }
  }
}

// A square of 2 x 2 at z = 0 that looks along +z, seen from 4 away; it is the second of three
// objects, and fills the middle half of each side of the picture.
Scene square_scene() {
  Scene scene;
  const auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh->materials = {2};
  scene.meshes = {mesh};
  scene.materials.resize(4);
  scene.materials[2].albedo = {0.5f, 0.25f, 0.125f};
  scene.instances.resize(3);
  scene.instances[0].object_to_world.m[2][3] = -1;  // hidden behind it
  scene.instances[2].object_to_world.m[2][3] = 50;  // behind the camera
  return scene;
}

FrameSettings square_settings() {
  FrameSettings settings;
  settings.width_px = settings.height_px = 16;
  settings.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 53.130102f};
  settings.planes = PlaneSet::all();
  return settings;
}

TEST(PlaneTile, HoldsWhatIsKnownOfASquare) {
  const Planes planes = planes_of(square_scene(), square_settings());
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const auto at = static_cast<std::size_t>(16 * y + x);
      const bool is_in = x >= 4 && x < 12 && y >= 4 && y < 12;
      const auto value = [&](Plane plane, std::size_t channel = 0) {
        return of(planes, plane)[at * plane_row(plane).channel_count() + channel];
      };
      EXPECT_EQ(value(Plane::kAlpha), is_in ? 1 : 0) << x << " " << y;
      EXPECT_EQ(value(Plane::kSamples), 1);
      EXPECT_EQ(value(Plane::kObject), is_in ? 2 : 0);
      EXPECT_EQ(value(Plane::kMaterial), is_in ? 3 : 0);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(value(Plane::kAlbedo, c),
                  is_in ? square_scene().materials[2].albedo[static_cast<int>(c)] : 0);
        EXPECT_EQ(value(Plane::kNormal, c), is_in && c == 2 ? 1 : 0);
      }
      // Depth is along the view and not along the ray, so that it is the same all over. 1e-6: two
      // roundings of 4.
      if (is_in) {
        EXPECT_NEAR(value(Plane::kDepth), 4, 1e-6f);
      } else {
        EXPECT_EQ(value(Plane::kDepth), kInfinity);
      }
      // A pixel is a quarter of a unit wide there; positions have some roundings of 4 units.
      EXPECT_NEAR(value(Plane::kPosition, 0), is_in ? (static_cast<float>(x) + 0.5f - 8) / 4 : 0,
                  2e-6f);
      EXPECT_NEAR(value(Plane::kPosition, 1), is_in ? (8 - static_cast<float>(y) - 0.5f) / 4 : 0,
                  2e-6f);
      EXPECT_NEAR(value(Plane::kPosition, 2), 0, 2e-6f);
    }
  }
}

// Depth, position, object and material are those of one hit, the nearest. Planes that hold means
// count misses as 0.
TEST(PlaneTile, SeveralSamplesAreMergedAsTheRowsSay) {
  Scene scene = square_scene();
  FrameSettings settings = square_settings();
  settings.samples_per_pixel = 8;
  settings.width_px = settings.height_px = 15;  // borders of the square cut pixels
  const Planes planes = planes_of(scene, settings);
  int partial = 0;
  for (std::size_t at = 0; at < 225; ++at) {
    const float alpha = of(planes, Plane::kAlpha)[at];
    EXPECT_EQ(of(planes, Plane::kSamples)[at], 8);
    EXPECT_EQ(alpha * 8, std::round(alpha * 8));
    EXPECT_EQ(of(planes, Plane::kNormal)[3 * at + 2], alpha);
    EXPECT_EQ(of(planes, Plane::kAlbedo)[3 * at], 0.5f * alpha);
    EXPECT_EQ(of(planes, Plane::kObject)[at], alpha > 0 ? 2 : 0);
    EXPECT_EQ(of(planes, Plane::kMaterial)[at], alpha > 0 ? 3 : 0);
    EXPECT_EQ(std::isinf(of(planes, Plane::kDepth)[at]), alpha == 0);
    partial += alpha > 0 && alpha < 1;
  }
  EXPECT_GT(partial, 8);
}

// Of two squares one behind the other, the front one is kept. Its border lies in column 11, of
// which it covers a quarter.
TEST(PlaneTile, TheNearestHitIsTheOneThatIsKept) {
  Scene scene = square_scene();
  scene.instances[0].object_to_world.m[0][3] = 1.07f;  // now seen beside the front one
  FrameSettings settings = square_settings();
  settings.samples_per_pixel = 16;
  settings.width_px = settings.height_px = 15;
  const Planes planes = planes_of(scene, settings);
  for (std::size_t y = 5; y < 10; ++y) {
    for (std::size_t x = 4; x < 13; ++x) {
      const std::size_t at = 15 * y + x;
      const bool is_front = x < 12;
      EXPECT_EQ(of(planes, Plane::kAlpha)[at], 1);
      EXPECT_EQ(of(planes, Plane::kObject)[at], is_front ? 2 : 1) << x;
      EXPECT_NEAR(of(planes, Plane::kDepth)[at], is_front ? 4 : 5, 2e-6f);
      EXPECT_NEAR(of(planes, Plane::kPosition)[3 * at + 2], is_front ? 0 : -1, 2e-6f);
    }
  }
}

// A ray that passes a surface by its alpha misses it; every ray misses a mask that is cut out.
TEST(PlaneTile, AlphaIsTheShareOfSamplesThatMeetSomething) {
  Scene scene = square_scene();
  scene.instances.resize(1);
  FrameSettings settings = square_settings();
  settings.samples_per_pixel = 256;
  scene.materials[2].alpha.mode = AlphaMode::kBlend;
  scene.materials[2].alpha.value = 0.25f;
  Planes planes = planes_of(scene, settings);
  double sum = 0;
  int count = 0;
  for (std::size_t y = 6; y < 10; ++y) {
    for (std::size_t x = 6; x < 10; ++x, ++count) sum += of(planes, Plane::kAlpha)[16 * y + x];
  }
  // 16 * 256 trials of 1/4: a standard deviation of 0.0068.
  EXPECT_NEAR(sum / count, 0.25, 5 * 0.0068);
  scene.materials[2].alpha.mode = AlphaMode::kMask;
  planes = planes_of(scene, settings);
  EXPECT_EQ(of(planes, Plane::kAlpha)[16 * 8 + 8], 0) << "below the cutoff";
}

// A normal is on the viewer's side. The albedo of mirrors and glass is their specular colour, and
// that of unlit surfaces is their colour.
TEST(PlaneTile, NormalsLookAtTheViewerAndAlbedoIsWhatReflects) {
  FrameSettings settings = square_settings();
  settings.camera.eye.z = -4;  // sees the square from behind
  Scene scene = square_scene();
  scene.instances.resize(1);
  const std::size_t middle = 16 * 8 + 8;
  EXPECT_EQ(of(planes_of(scene, settings), Plane::kNormal)[3 * middle + 2], -1);
  scene.materials[2].specular = {0.75f, 0.5f, 1};
  for (const BsdfKind kind : {BsdfKind::kMirror, BsdfKind::kGlass}) {
    scene.materials[2].bsdf = kind;
    const Planes planes = planes_of(scene, settings);
    EXPECT_EQ(of(planes, Plane::kAlbedo)[3 * middle + 1], 0.5f);
    EXPECT_EQ(of(planes, Plane::kAlpha)[middle], 1);
  }
  scene.materials[2].bsdf = BsdfKind::kDiffuse;
  scene.materials[2].is_unlit = true;
  EXPECT_EQ(of(planes_of(scene, settings), Plane::kAlbedo)[3 * middle], 0.5f);
}

// Planes are traced with the renderer's rays: colour is the background's, to the bit, exactly where
// no sample has a hit.
TEST(PlaneTile, AlphaFitsTheColourOfEachRenderer) {
  Scene scene = test::make_scene(test::make_icosphere(3));
  scene.environment = {1, 1, 1};
  scene.background = {BackgroundKind::kGradient, {}, {}};
  FrameSettings settings = settings_of(4);
  const Planes planes = planes_of(scene, settings);
  int covered = 0, partial = 0;
  for (const Renderer renderer :
       {Renderer::kPrimary, Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    settings.renderer = renderer;
    const std::vector<float> rgb = test::render(scene, settings);
    for (std::size_t at = 0; at < rgb.size() / 3; ++at) {
      const float alpha = of(planes, Plane::kAlpha)[at];
      ASSERT_EQ(rgb[3 * at] > 0, alpha > 0) << renderer_name(renderer) << " " << at;
      covered += alpha == 1;
      partial += alpha > 0 && alpha < 1;
    }
  }
  EXPECT_GT(covered, 1000);
  EXPECT_GT(partial, 100);
}

TEST(PlaneTile, ACancelledTileIsLeft) {
  const auto prepared = PreparedScene::build(square_scene(), {});
  ASSERT_TRUE(prepared.is_ok());
  const FrameSettings settings = square_settings();
  std::vector<float> values(256 * channel_count(settings.planes));
  const std::atomic<bool> is_cancelled = true;
  PlaneTile tile;
  EXPECT_EQ(tile.render(**prepared, settings, Isa::kScalar, {0, 0, 16, 16}, values, &is_cancelled)
                .primary,
            0u);
}

}  // namespace
}  // namespace tessera::core
