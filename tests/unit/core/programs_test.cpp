// SPDX-License-Identifier: Apache-2.0
// Programs of surfaces, and the noise that they are made of.
#include "slave/core/surface/programs.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/surface_at.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

float gradient(Vec3f p, std::uint32_t seed) {
  float value = 0;
  Noise(kernels_for(Isa::kScalar).noise)
      .gradient({{&p.x, 1}, {&p.y, 1}, {&p.z, 1}}, seed, {&value, 1});
  return value;
}

TEST(Programs, NoiseIsZeroOnItsLatticeBoundedAndAsStrongAsItsMeanSays) {
  double size = 0, mean = 0;
  float least = 0, greatest = 0;
  std::mt19937 random(test::seed(5));
  std::uniform_real_distribution<float> unit(-1000, 1000);
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) {
    const float n = gradient({unit(random), unit(random), unit(random)}, 9);
    size += std::fabs(n) / double{kCount};
    mean += n / double{kCount};
    least = std::min(least, n);
    greatest = std::max(greatest, n);
  }
  EXPECT_EQ(gradient({3, -4, 7}, 1), 0);
  EXPECT_NEAR(size, 0.21, 0.02) << "kMeanSize of noise.cpp";
  EXPECT_NEAR(mean, 0, 0.01);
  EXPECT_GE(least, -1);
  EXPECT_LE(greatest, 1);
  EXPECT_GT(greatest, 0.6f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(gradient({nan, 0.5f, 0.5f}, 1), 0);
  EXPECT_EQ(gradient({1e30f, 0.5f, 0.5f}, 1), 0);
}

Vec3f programmed(SurfaceKind kind, Vec3f point, Vec3f normal, float footprint,
                 NoiseKernel noise = kernels_for(Isa::kScalar).noise) {
  Surface s;
  s.albedo = {0.8f, 0.7f, 0.6f};
  Surface* const surface = &s;
  const auto axes = [](const Vec3f& p) {
    return SurfacePlaces::Axes{{{&p.x, 1}, {&p.y, 1}, {&p.z, 1}}};
  };
  apply_surface_program({kind, find_surface_program(kind)->defaults}, Noise(noise),
                        {axes(point), axes(normal), {&footprint, 1}, {&surface, 1}});
  return s.albedo;
}

// The bits of patterns are the same on every machine; the hash of them is written down here.
TEST(Programs, GiveTheSameBitsEverywhere) {
  for (const Isa isa : test::isas_here()) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const SurfaceProgramShape& shape : surface_programs()) {
      for (int i = 0; i < 4096; ++i) {
        const float x = static_cast<float>(i % 16) * 0.173f - 1,
                    z = static_cast<float>(i / 256) * 0.119f;
        const Vec3f point{x, static_cast<float>(i / 16 % 16) * 0.0917f, z};
        const Vec3f c = programmed(shape.kind, point, {z, 0.5f, x}, i % 3 == 0 ? 0 : 0.01f,
                                   kernels_for(isa).noise);
        for (int a = 0; a < 3; ++a) {
          ASSERT_TRUE(c[a] >= 0 && c[a] <= 1) << shape.name << " " << i;
          hash = (hash ^ std::bit_cast<std::uint32_t>(c[a])) * 0x100000001b3u;
        }
      }
    }
    EXPECT_EQ(hash, 13810743347628684008u) << isa_name(isa);
  }
}

// The pattern of a place does not depend on the places that are evaluated beside it.
TEST(Programs, DoNotDependOnCompany) {
  std::mt19937 random(test::seed(8));
  std::uniform_real_distribution<float> unit(-3, 3);
  for (const Isa isa : test::isas_here()) {
    for (const SurfaceProgramShape& shape : surface_programs()) {
      const std::size_t count = 1 + random() % kPlacesMax;
      std::vector<Surface> surface(count);
      std::vector<Surface*> to;
      std::vector<float> point[3], normal[3], footprint;
      for (Surface& s : surface) {
        s.albedo = {0.8f, 0.7f, 0.6f};
        to.push_back(&s);
        for (int a = 0; a < 3; ++a) {
          point[a].push_back(unit(random));
          normal[a].push_back(unit(random));
        }
        footprint.push_back(std::max(0.0f, 0.1f * unit(random)));
      }
      const NoiseKernel noise = kernels_for(isa).noise;
      apply_surface_program(
          {shape.kind, shape.defaults}, Noise(noise),
          {{{point[0], point[1], point[2]}}, {{normal[0], normal[1], normal[2]}}, footprint, to});
      for (std::size_t i = 0; i < count; ++i) {
        const auto at = [i](const auto(&v)[3]) { return Vec3f{v[0][i], v[1][i], v[2][i]}; };
        const Vec3f alone = programmed(shape.kind, at(point), at(normal), footprint[i], noise);
        EXPECT_EQ(alone, surface[i].albedo) << shape.name << " " << i << " " << isa_name(isa);
      }
    }
  }
}

// From far away a pattern is its mean, without flicker.
TEST(Programs, FadeIntoTheirMean) {
  for (const SurfaceKind kind : {SurfaceKind::kMarble, SurfaceKind::kWood, SurfaceKind::kBrick}) {
    std::mt19937 random(test::seed(6));
    std::uniform_real_distribution<float> unit(-20, 20);
    Vec3f near, far;
    float least = 1, greatest = 0;
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
      const Vec3f p{unit(random), unit(random), 0};
      near = near + programmed(kind, p, {0, 0, 1}, 0) * (1.0f / kCount);
      const Vec3f c = programmed(kind, p, {0, 0, 1}, 2);
      far = far + c * (1.0f / kCount);
      least = std::min(least, c.x);
      greatest = std::max(greatest, c.x);
    }
    EXPECT_LT(length(near - far), 0.04f) << find_surface_program(kind)->name;
    EXPECT_LT(greatest - least, 0.04f) << find_surface_program(kind)->name;
  }
}

// An instance that is moved, turned and shrunk has the pattern of its mesh.
TEST(Programs, PatternsStayWithTheMesh) {
  Scene scene = test::make_scene(test::make_icosphere(1));
  scene.materials[0].surface = {SurfaceKind::kMarble,
                                find_surface_program(SurfaceKind::kMarble)->defaults};
  Instance moved;
  moved.object_to_world.m = {{{0, -0.5f, 0, 7}, {0.5f, 0, 0, 1}, {0, 0, 0.5f, -3}}};
  scene.instances.push_back(moved);
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  const auto& impl = (*prepared)->impl();
  for (std::uint32_t i = 0; i < 80; ++i) {
    const auto straight_on = [&](std::uint32_t triangle) {
      const auto corner = [&](int k) { return impl.triangles.vertex(triangle, k); };
      const Vec3f outward = cross(corner(1) - corner(0), corner(2) - corner(0));
      return test::surface_at(impl, triangle, 0.2f, 0.5f, -normalize(outward));
    };
    const Surface here = straight_on(i), there = straight_on(i + 80);
    EXPECT_LT(length(here.albedo - there.albedo), 1e-4f) << i;
  }
}

}  // namespace
}  // namespace tessera::core
