// SPDX-License-Identifier: Apache-2.0
// Property: the decision of patches says the same in registers as for a ray alone, to the bit of t,
// u and v, on every instruction set, for patches with and without weights, of several degrees, and
// for rays that are no rays.
#include "tests/property/patch/patch_lanes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "slave/core/primitive/patch/patch_decision.h"
#include "tests/support/packets.h"
#include "tests/support/patch_rays.h"

namespace tessera::core {
namespace {

using test::PatchRays;

std::uint64_t bits(double a) { return std::bit_cast<std::uint64_t>(a); }

TEST(PatchLanes, DecideAsOneRayDoes) {
  constexpr PatchRays kKinds[] = {PatchRays::kCamera, PatchRays::kBorder, PatchRays::kGrazing};
  for (const char* name : {"teapot", "torus", "cone", "sheets", "degree15x9"}) {
    SCOPED_TRACE(name);
    const test::PatchScene scene(test::patch_shape(name));
    test::PatchRayMaker maker(scene, false, 20090);
    const auto part_count = static_cast<unsigned>(scene.parts().parts.size());
    std::size_t hits = 0, undecided = 0;
    for (int group = 0; group < 400; ++group) {
      const SubPatch& part = scene.parts().parts[maker.any().below(part_count)];
      if (!part.has_frame) continue;
      const Patch patch = scene.patch(part.patch);
      PatchRay rays[kPatchLanes];
      PatchLaneRays lanes{};
      for (std::size_t i = 0; i < kPatchLanes; ++i) {
        rays[i] = maker.next(kKinds[group % 3]);
        // Most rays pass the part's box.
        const Bounds3f& box =
            scene.parts().boxes[static_cast<std::size_t>(&part - scene.parts().parts.data())];
        const Vec3f middle = 0.5f * (box.lower + box.upper);
        for (int a = 0; a < 3; ++a) {
          if (i % 4 != 0)
            rays[i].direction[a] =
                middle[a] + box.extent()[a] * maker.any().sign() / 2 - rays[i].origin[a];
          if (maker.any().one_in(256)) rays[i].direction[a] = i % 2 == 0 ? 0 : NAN;
          lanes.origin[a][i] = double{rays[i].origin[a]};
          lanes.direction[a][i] = double{rays[i].direction[a]};
        }
      }
      for (const Isa isa : test::isas_here()) {
        PatchLaneAnswers answers{};
        decide_patch_lanes(isa)(patch, part, lanes, answers);
        for (std::size_t i = 0; i < kPatchLanes; ++i) {
          const PatchDecision alone = decide(patch, part, rays[i]);
          ASSERT_EQ((answers.is_hit >> i & 1) != 0, alone.is_hit) << isa_name(isa);
          ASSERT_EQ((answers.is_undecided >> i & 1) != 0, alone.is_undecided) << isa_name(isa);
          hits += alone.is_hit;
          undecided += alone.is_undecided;
          if (!alone.is_hit) continue;
          ASSERT_EQ(bits(answers.t[i]), bits(alone.t)) << isa_name(isa);
          ASSERT_EQ(bits(answers.u[i]), bits(alone.u)) << isa_name(isa);
          ASSERT_EQ(bits(answers.v[i]), bits(alone.v)) << isa_name(isa);
        }
      }
    }
    EXPECT_GT(hits, 1'000u);
    EXPECT_GT(undecided, 10u);
  }
}

}  // namespace
}  // namespace tessera::core
