// SPDX-License-Identifier: Apache-2.0
// A new BSDF takes one file and two rows: rough_diffuse-inl.h, kind.inc and row.inc. The tables are
// compiled once more here, with those rows; all else is the library's.
#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/material_bytes.h"
#include "common/scene/validate.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/bsdf_at.h"
#include "tests/support/packets.h"
#include "tests/support/render.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr int kSlot = static_cast<int>(BsdfKind::kRoughDiffuse);
constexpr float kAlbedo = 0.7f, kRoughness = 0.8f;

Surface rough_surface(const Material& material, float viewer_z) {
  Surface s;
  s.normal = s.shading_normal = {0, 0, 1};
  s.bsdf = BsdfKind::kRoughDiffuse;
  s.material = &material;
  s.albedo = {kAlbedo, kAlbedo, kAlbedo};
  s.roughness = kRoughness;
  s.to_viewer = {std::sqrt(1 - viewer_z * viewer_z), 0, viewer_z};
  return s;
}

// Share of an even sky that a surface reflects, by the midpoint rule over the unit square.
double albedo_by_quadrature(const Surface& s) {
  constexpr int kCells = 128;
  double sum = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const auto middle = [](int cell) { return static_cast<float>(2 * cell + 1) / (2 * kCells); };
      const Vec3f light = cosine_direction(s.shading_normal, {middle(i), middle(j)});
      sum += double{test::evaluate(s, s.to_viewer, light).times_pi.x};
    }
  }
  return sum / (kCells * kCells);
}

TEST(ExampleBsdf, HasItsNameAndItsPlace) {
  ASSERT_NE(find_bsdf("rough-diffuse"), nullptr);
  EXPECT_EQ(*find_bsdf("rough-diffuse"), BsdfKind::kRoughDiffuse);
  EXPECT_EQ(last_bsdf(), BsdfKind::kRoughDiffuse);
  EXPECT_EQ(scattering_of(BsdfKind::kRoughDiffuse), Scattering::kLobes);
  EXPECT_FALSE(is_known(static_cast<BsdfKind>(kSlot + 1)));
}

TEST(ExampleBsdf, TravelsToSlavesAndIsValid) {
  Scene scene = test::make_scene(test::make_icosphere(1));
  scene.materials[0].bsdf = BsdfKind::kRoughDiffuse;
  EXPECT_TRUE(validate_scene(scene).is_ok());
  BlockWriter out(BlockKind::kRoot);
  put_material(out, scene.materials[0]);
  const std::vector<std::byte> bytes = out.finish();
  BlockReader in(bytes);
  Material back;
  ASSERT_TRUE(in.open(BlockKind::kRoot) && get_material(in, back));
  EXPECT_EQ(back, scene.materials[0]);
}

TEST(ExampleBsdf, SamplesFollowTheirPdfAndReflectTheSameOnEverySet) {
  const Material material;
  for (const float viewer_z : {1.0f, 0.6f, 0.1f}) {
    const Surface s = rough_surface(material, viewer_z);
    const double expected = albedo_by_quadrature(s);
    EXPECT_LE(expected, double{kAlbedo} * 1.001);
    for (const Isa isa : test::isas_here()) {
      double sum = 0;
      constexpr int kRounds = 64;
      for (std::uint32_t round = 0; round < kRounds; ++round) {
        BsdfPacket packet;
        for (std::uint32_t i = 0; i < BsdfPacket::kMax; ++i)
          packet.add(s, nullptr, sample_2d(7, round * BsdfPacket::kMax + i));
        packet.sample(kernels_for(isa), kSlot);
        for (int i = 0; i < packet.count(); ++i) {
          sum += double{packet.weight(i).x};
          const auto again = test::evaluate(s, s.to_viewer, packet.direction(i));
          EXPECT_NEAR(again.pdf, packet.pdf(i), 1e-6);
        }
      }
      EXPECT_NEAR(sum / (kRounds * BsdfPacket::kMax), expected, 0.002) << viewer_z;
    }
  }
}

TEST(ExampleBsdf, IsReciprocal) {
  const Material material;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Vec3f a = cosine_direction({0, 0, 1}, sample_2d(1, i));
    const Vec3f b = cosine_direction({0, 0, 1}, sample_2d(2, i));
    if (!(a.z > 0) || !(b.z > 0)) continue;
    const Surface s = rough_surface(material, 1);
    EXPECT_NEAR(test::evaluate(s, a, b).times_pi.x, test::evaluate(s, b, a).times_pi.x, 1e-6);
  }
}

// All renderers light the BSDF: by direct light, by paths and by VPLs a ball under an even sky is
// as bright as the albedo of its surface by quadrature.
TEST(ExampleBsdf, IsLitByEveryRenderer) {
  Scene scene = test::make_scene(test::make_icosphere(3));
  scene.materials[0].bsdf = BsdfKind::kRoughDiffuse;
  scene.materials[0].albedo = {kAlbedo, kAlbedo, kAlbedo};
  scene.materials[0].roughness = kRoughness;
  scene.environment = {1, 1, 1};
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.camera = {{0, 0, 1.2f}, {0, 0, 0}, {0, 1, 0}, 6};  // sees the middle of the ball alone
  settings.samples_per_pixel = 64;
  settings.bounces = 2;
  const double expected = albedo_by_quadrature(rough_surface(scene.materials[0], 1));
  for (const Renderer renderer : {Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    settings.renderer = renderer;
    double mean = 0;
    const std::vector<float> rgb = test::render(scene, settings);
    for (const float x : rgb) mean += double{x} / static_cast<double>(rgb.size());
    EXPECT_NEAR(mean, expected, 0.01) << renderer_name(renderer);
  }
}

}  // namespace
}  // namespace tessera::core
