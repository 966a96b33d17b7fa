// SPDX-License-Identifier: Apache-2.0
// Property: no ray from inside of a closed shape of patches leaves it: not through the borders that
// patches share, nor those of sub-patches, nor borders that are one point; at any scale, far from
// the origin, for any splitting; and what it meets is where the equation of the shape says.
// TESSERA_LONG=1 asks for 50 times as many rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "tests/support/patch_rays.h"

namespace tessera {
namespace {

using test::PatchRays;

int rays(int few) { return std::getenv("TESSERA_LONG") == nullptr ? few : 50 * few; }

std::size_t leaks(const std::string& name, PatchRays kind, int count, float scale, float shift,
                  const core::PatchSplitting& splitting) {
  auto patches = test::patch_shape(name);
  if (scale != 1 || shift != 0) patches = test::moved(patches, scale, shift);
  test::PatchScene scene(std::move(patches), splitting);
  test::PatchRayMaker maker(scene, name == "torus", 20088, scale, shift);
  const auto solver = std::make_unique<core::CompleteSolver>();
  std::size_t found = 0;
  for (int k = 0; k < count; ++k) {
    const core::PatchRay ray = maker.next(kind);
    // Rays at borders end on them at t = 1, or before; the target is rounded to float32.
    const double end = kind == PatchRays::kInsideAtBorder ? 1.01 : INFINITY;
    const auto hit = scene.trace(ray, *solver);
    found += !(hit.is_hit && hit.t <= end);
  }
  return found;
}

TEST(PatchBorders, NoRayFromInsideLeaves) {
  for (const char* name : {"sphere", "cylinder", "cone", "torus"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(leaks(name, PatchRays::kInsideAtBorder, rays(20'000), 1, 0, {}), 0u);
    EXPECT_EQ(leaks(name, PatchRays::kInside, rays(4'000), 1, 0, {}), 0u);
  }
}

TEST(PatchBorders, NorDoTheyWhereverTheShapeIs) {
  for (const char* name : {"sphere", "cylinder", "cone", "torus"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(leaks(name, PatchRays::kInsideAtBorder, rays(2'000), 1e-6f, 0, {}), 0u);
    EXPECT_EQ(leaks(name, PatchRays::kInsideAtBorder, rays(2'000), 1e15f, 0, {}), 0u);
    EXPECT_EQ(leaks(name, PatchRays::kInsideAtBorder, rays(2'000), 1, 1e3f, {}), 0u);
  }
}

TEST(PatchBorders, NorHoweverItIsSplit) {
  for (const char* name : {"sphere", "cylinder", "cone", "torus"})
    for (const double radius : {0.2, 4.0})
      for (const int level_max : {0, 3, 7}) {
        SCOPED_TRACE(name);
        core::PatchSplitting splitting;
        splitting.radius = radius;
        splitting.level_max = level_max;
        EXPECT_EQ(leaks(name, PatchRays::kInsideAtBorder, rays(300), 1, 0, splitting), 0u);
      }
}

// Where the line O + t D meets a sphere of radius 1 from inside.
double of_sphere(const core::PatchRay& ray) {
  double dd = 0, od = 0, oo = 0;
  for (int a = 0; a < 3; ++a) {
    const double o = double{ray.origin[a]}, d = double{ray.direction[a]};
    dd += d * d;
    od += o * d;
    oo += o * o;
  }
  return (-od + std::sqrt(od * od - dd * (oo - 1))) / dd;
}

// How far the end of a ray is from the shape's equation.
double off_shape(const std::string& name, const core::PatchRay& ray, double t) {
  double p[3] = {};
  for (int a = 0; a < 3; ++a) p[a] = double{ray.origin[a]} + t * double{ray.direction[a]};
  const double r = std::hypot(p[0], p[1]), z = p[2];
  if (name == "torus") return std::fabs(std::hypot(r - 1, z) - double{test::kTubeRadius});
  const double side = name == "cone" ? std::fabs(r - (1 - z) / 2) : std::fabs(r - 1);
  return std::min({side, std::fabs(z - 1), std::fabs(z + 1)});
}

// Shapes of weights in float32 are round to 2^-23 (patch_surface_test.cpp).
TEST(PatchBorders, HitsAreWhereEquationsSay) {
  for (const std::string name : {"sphere", "cylinder", "cone", "torus"}) {
    SCOPED_TRACE(name);
    test::PatchScene scene(test::patch_shape(name));
    test::PatchRayMaker maker(scene, name == "torus", 20089);
    const auto solver = std::make_unique<core::CompleteSolver>();
    for (int k = 0; k < rays(5'000); ++k) {
      const core::PatchRay ray = maker.next(PatchRays::kInside);
      const auto hit = scene.trace(ray, *solver);
      ASSERT_TRUE(hit.is_hit) << "ray " << k;
      if (name == "sphere") {
        // From near the middle the surface is seen at less than 5 degrees from its normal.
        ASSERT_NEAR(hit.t / of_sphere(ray), 1, 0x1p-22) << "ray " << k;
      } else {
        ASSERT_LE(off_shape(name, ray, hit.t), 0x1p-22) << "ray " << k;
      }
    }
  }
}

}  // namespace
}  // namespace tessera
