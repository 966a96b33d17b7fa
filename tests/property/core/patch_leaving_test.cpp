// SPDX-License-Identifier: Apache-2.0
// Property: a ray that goes on from where another has met a patch does not meet the root that it
// starts on, however flat it leaves, and passes no second sheet by that is some roundings away
// (patch_point.h derives how far from the surface it starts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "slave/core/primitive/freeform/patch_point.h"
#include "tests/support/choices.h"
#include "tests/support/patch_shapes.h"

namespace tessera {
namespace {

using test::Choices;
using test::PatchScene;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr int kRays = 4000;
// Of the direction to the surface: far more than what rounds it, and as flat as rays matter.
constexpr float kFlattest = 0x1p-19f;

core::PatchRay ray_from(Vec3f origin, Vec3f direction) {
  return {{origin.x, origin.y, origin.z}, {direction.x, direction.y, direction.z}, 0, kInf};
}

// Where a ray from far away has met a body, with the normal that faces it.
struct Met {
  core::PatchSurfacePoint at;
  Vec3f facing;
};

bool meet(PatchScene& scene, core::CompleteSolver& solver, Vec3f middle, Choices& choices,
          Met& met) {
  const Vec3f from = middle + 4.0f * normalize(choices.point(1));
  const Vec3f direction = middle + choices.point(0.7f) - from;
  const core::PatchRay ray = ray_from(from, direction);
  const PatchScene::Hit hit = scene.trace(ray, solver);
  if (!hit.is_hit) return false;
  met.at = core::patch_point(scene.patch(hit.patch), scene.parts().parts[hit.part], ray.origin,
                             ray.direction, static_cast<float>(hit.t));
  met.facing = dot(met.at.normal, direction) < 0 ? met.at.normal : -1.0f * met.at.normal;
  return true;
}

// Half of the directions are flat.
Vec3f leaving(Vec3f normal, Choices& choices) {
  const Vec3f any = choices.point(1);
  const Vec3f along = normalize(any - dot(any, normal) * normal);
  const float rise = choices.one_in(2) ? choices.share() : choices.power(-5.5f, 0);
  return along + std::max(rise, kFlattest) * normal;
}

TEST(PatchLeaving, RaysDoNotMeetTheRootThatTheyStartOn) {
  Choices choices(611);
  core::CompleteSolver solver;
  for (const char* shape : {"sphere", "cylinder", "cone"}) {
    for (const float shift : {0.0f, 10.0f, 1000.0f}) {
      PatchScene body(test::moved(test::patch_shape(shape), 1, shift));
      int met_itself = 0, left = 0;
      for (int i = 0; i < kRays; ++i) {
        Met met;
        if (!meet(body, solver, {shift, shift, shift}, choices, met)) continue;
        const Vec3f start = met.at.point + met.at.offset * met.facing;
        ++left;
        // What is convex is not met again from outside.
        met_itself += body.trace(ray_from(start, leaving(met.facing, choices)), solver).is_hit;
      }
      EXPECT_GT(left, kRays / 4) << shape;
      EXPECT_EQ(met_itself, 0) << shape << " at " << shift << ", of " << left;
    }
  }
}

// A second sphere stands around the first, and one within it, so near that rays from the first
// start closer to it than they would have to.
TEST(PatchLeaving, RaysMeetASecondSheetThatIsSomeRoundingsAway) {
  Choices choices(612);
  core::CompleteSolver solver;
  for (const float shift : {0.0f, 10.0f, 1000.0f}) {
    const auto sphere = test::patch_shape("sphere");
    PatchScene body(test::moved(sphere, 1, shift));
    const float size = 1 + 2 * std::fabs(shift);
    const float gap = 16 * 0x1p-24f * size;
    for (const bool is_around : {true, false}) {
      PatchScene other(test::moved(sphere, is_around ? 1 + gap : 1 - gap, shift));
      int passed = 0, left = 0;
      float farthest = 0;
      for (int i = 0; i < kRays; ++i) {
        Met met;
        if (!meet(body, solver, {shift, shift, shift}, choices, met)) continue;
        const Vec3f side = is_around ? met.facing : -1.0f * met.facing;
        const Vec3f start = met.at.point + met.at.offset * side;
        farthest = std::max(farthest, met.at.offset);
        ++left;
        const Vec3f direction = is_around ? leaving(side, choices) : side;
        passed += !other.trace(ray_from(start, direction), solver).is_hit;
      }
      std::printf("at %g: rays start up to %.2g away from the first, %.2g are between\n",
                  static_cast<double>(shift), static_cast<double>(farthest),
                  static_cast<double>(gap));
      EXPECT_GT(left, kRays / 4);
      EXPECT_EQ(passed, 0) << shift << ", of " << left;
    }
  }
}

}  // namespace
}  // namespace tessera
