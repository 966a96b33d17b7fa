// SPDX-License-Identifier: Apache-2.0
// Property: a ray that leaves a sub-patch above the horizon of its point does not meet that
// sub-patch again, but for the rounding of where it begins. So traversals may leave the sub-patch
// out for such rays. Where surfaces are smooth, most rays are such. TESSERA_LONG=1: fifty times as
// many.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "common/math/rounding.h"
#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_horizon.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "tests/support/choices.h"
#include "tests/support/patch_shapes.h"

namespace tessera {
namespace {

using test::Choices;
using test::PatchScene;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNone = 2;  // as a sine: no ray is as steep

struct Place {
  std::uint32_t part = 0;
  Vec3f point, normal;  // unit, on a side that was chosen
  float offset = 0, horizon = kNone;
  float rounding = 0;  // how far a ray that starts at the offset is from the surface, at most
};

// A point of a part that has a normal. Returns: whether this one has.
bool choose(const PatchScene& scene, Choices& choices, Place& to) {
  to.part = choices.below(static_cast<unsigned>(scene.parts().parts.size()));
  const core::SubPatch& part = scene.parts().parts[to.part];
  const core::Patch patch = scene.patch(part.patch);
  const core::SubPatchRange range(part);
  // Borders and corners are as frequent as all between them.
  const auto within = [&] {
    return choices.one_in(4) ? std::copysign(1.0f, choices.sign()) : choices.sign();
  };
  const auto u = static_cast<float>(range.middle_u + range.half_u * double{within()});
  const auto v = static_cast<float>(range.middle_v + range.half_v * double{within()});
  const core::PatchJet jet = core::evaluate(patch, double{u}, double{v});
  const Vec3d du{jet.du[0], jet.du[1], jet.du[2]}, dv{jet.dv[0], jet.dv[1], jet.dv[2]};
  const Vec3d across = cross(du, dv);
  if (!(length(across) > 1e-6 * length(du) * length(dv))) return false;
  const Vec3d normal = (choices.one_in(2) ? 1 / length(across) : -1 / length(across)) * across;
  to.point = rounded(Vec3d{jet.point[0], jet.point[1], jet.point[2]});
  to.normal = rounded(normal);
  const float size = std::max({std::fabs(to.point.x), std::fabs(to.point.y), std::fabs(to.point.z),
                               static_cast<float>(patch.extent)});
  to.offset = 8 * kUnitRoundoff * size;
  to.rounding = to.offset + 4 * kUnitRoundoff * size;
  to.horizon = core::horizon_at(patch, part, u, v, to.point, to.normal).value_or(kNone);
  return true;
}

// A unit direction at the sine of an angle above the plane.
Vec3f direction_at(Vec3f normal, float sine, Choices& choices) {
  const Vec3f any = choices.point(1);
  const Vec3f along = normalize(any - dot(any, normal) * normal);
  return sine * normal + std::sqrt(std::max(1 - sine * sine, 0.0f)) * along;
}

struct Sum {
  int rays = 0, known = 0, met = 0;
};

// Rays of which a half leave at, or next to, the horizon. Returns: of those that leave by the
// cosine, how many leave above it; and of all above it, how many have met the part farther away
// than rounding explains.
Sum leave(PatchScene& scene, int count, Choices& choices) {
  core::CompleteSolver solver;
  Sum sum;
  for (int i = 0; i < count; ++i) {
    Place at;
    if (!choose(scene, choices, at)) continue;
    const bool is_next = choices.one_in(2) && at.horizon < 1;
    const float sine =
        is_next ? std::min(at.horizon + choices.power(-7, -1), 1.0f) : std::sqrt(choices.share());
    sum.rays += !is_next;
    if (sine < at.horizon) continue;
    sum.known += !is_next;
    const Vec3f d = choices.power(-3, 3) * direction_at(at.normal, sine, choices);
    const Vec3f o = at.point + at.offset * at.normal;
    const core::SubPatch& part = scene.parts().parts[at.part];
    const core::PatchHit hit = core::patch_hit(scene.patch(part.patch), part,
                                               {{o.x, o.y, o.z}, {d.x, d.y, d.z}, 0, kInf}, solver);
    const double room = double{at.rounding} / double{core::kHorizonRoom};
    sum.met += hit.is_hit && hit.t * double{length(d)} > room;
  }
  return sum;
}

TEST(PatchHorizon, RaysAboveItDoNotMeetTheirPartAgain) {
  const int count = std::getenv("TESSERA_LONG") == nullptr ? 40'000 : 2'000'000;
  Choices choices(1911);
  std::uint64_t known = 0;
  for (const char* shape : {"sphere", "cylinder", "cone", "torus", "teapot", "plane", "plane33",
                            "cusp", "fold", "sheets", "weights", "weights4x5"}) {
    for (const int levels : {0, 1, 8}) {
      for (const float shift : {0.0f, 100.0f}) {
        core::PatchSplitting splitting;
        splitting.level_max = levels;
        PatchScene scene(test::moved(test::patch_shape(shape), 1, shift), splitting);
        const Sum sum = leave(scene, count / 10, choices);
        EXPECT_EQ(sum.met, 0) << shape << ", " << levels << " levels, at " << shift;
        known += static_cast<std::uint64_t>(sum.known);
      }
    }
  }
  std::printf("%llu rays above their horizons\n", static_cast<unsigned long long>(known));
}

// Whole patches of the teapot bend by a quarter turn.
TEST(PatchHorizon, MostRaysLeaveSmoothSurfacesAboveIt) {
  Choices choices(1912);
  const auto share = [&](const char* shape, int levels) {
    core::PatchSplitting splitting;
    splitting.level_max = levels;
    PatchScene scene(test::patch_shape(shape), splitting);
    const Sum sum = leave(scene, 20'000, choices);
    std::printf("%s, %d levels: %.3f\n", shape, levels, sum.known / static_cast<double>(sum.rays));
    return sum.known / static_cast<double>(sum.rays);
  };
  EXPECT_GT(share("teapot", 0), 0.25);  // on either side
  EXPECT_GT(share("teapot", 8), 0.97);
  EXPECT_GT(share("sphere", 8), 0.97);
  EXPECT_GT(share("plane33", 0), 0.99);
}

}  // namespace
}  // namespace tessera
