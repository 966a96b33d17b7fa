// SPDX-License-Identifier: Apache-2.0
// Property: places that may share a surface of patches (surface_sharing.h) leave its patches an
// extent in the world, by what kernels know of the roundings of places.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "common/scene/surface_sharing.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/instance/instance_placement.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

// Maps from harmless ones to such as are nearly flat, or very far away.
Transform any_map(int number, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto power = [](int exponent) { return std::pow(10.0f, static_cast<float>(exponent)); };
  Transform t;
  for (auto& row : t.m) {
    for (float& x : row) x = unit(random);
    row[2] *= power(-(number % 7));
    row[3] *= power(number % 12);
  }
  return t;
}

TEST(SharedPatchRules, LeaveAnExtentThatIsMoreThanRoundings) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  std::mt19937 random(seed);
  const auto given = test::patch_scene_of("teapot").surfaces[0];
  const SharedSurface surface = shared_surface(given, splitting_for(1));
  const double extent = surface.reach.least_extent;
  ASSERT_GT(extent, 0);
  int shared_count = 0;
  constexpr int kMaps = 8400;
  for (int i = 0; i < kMaps; ++i) {
    const Transform t = any_map(i, random);
    if (!may_share(surface.reach, t)) continue;
    ++shared_count;
    const auto block = place_instance(t, surface.points);
    ASSERT_TRUE(block);
    for (int a = 0; a < 3; ++a) EXPECT_GT(extent, 3.99 * double{block->pad[a]});
  }
  EXPECT_GT(shared_count, kMaps / 10);
  EXPECT_LT(shared_count, kMaps - kMaps / 10);
}

TEST(SharedPatchRules, ReachHoldsControlPointsAndPassesPointsByThatArePatches) {
  const PatchForm forms[] = {{1, 1, 0, 0}, {1, 1, 1, 0}, {1, 1, 0, 0}};
  const float numbers[] = {0, 0, 0, 0, 1, 0, -5, 0,  0, -5, 1, 0,              // extent 5
                           8, 8, 8, 1, 8, 8, 8,  1,  8, 8,  8, 1, 8, 8, 8, 2,  // a point
                           0, 0, 0, 0, 2, 0, 1,  -9, 0, 1,  2};                // one is missing
  const SurfaceReach reach = reach_of(forms, numbers);
  EXPECT_EQ(reach.least_extent, 5);
  EXPECT_EQ(reach.largest, (std::array<double, 3>{8, 8, 8}));
}

}  // namespace
}  // namespace tessera::core
