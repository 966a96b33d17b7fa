// SPDX-License-Identifier: Apache-2.0
// Property: rays meet a surface beside its widened segments as far away as the widths say, no
// further, and nowhere else.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/trim_set.h"
#include "slave/core/scene/ray_caster.h"
#include "slave/core/simd/isa_support.h"
#include "tests/support/gaping_solids.h"

namespace tessera {
namespace {

using test::Choices;
using test::Cylinder;
using test::EdgePlace;
using test::SolidWriter;

constexpr double kWidth = 0.01;

// A square from (1, 1, 0) to (3, 3, 0) of a plane that goes on: its right side is widened.
PatchSurface widened_square() {
  SolidWriter writer;
  writer.add_plane({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  writer.keep_inside();
  writer.add_rectangle(0.25, 0.25, 0.75, 0.75, {0, kWidth, 0, 0});
  return writer.surface();
}

// A square from (0, 0, 0) to (1, 1, 0) that is the patch: its right side is widened.
PatchSurface widened_patch() {
  SolidWriter writer;
  writer.add_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  writer.add_side({1, 0}, {1, 1}, kWidth);
  return writer.surface();
}

std::shared_ptr<const core::PreparedScene> prepared(const PatchSurface& surface,
                                                    const Transform& to_world = {}) {
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {std::make_shared<const PatchSurface>(surface)};
  scene.instances = {{0, to_world, ObjectKind::kPatchSurface}};
  return core::PreparedScene::build(scene, {}).value();
}

core::CastHit hit(const core::PreparedScene& scene, Vec3f origin, Vec3f direction) {
  const core::CastRay ray{origin, direction, 0, Bounds3f::kInf};
  core::CastHit found;
  cast_rays(scene, {&ray, 1}, {}, {&found, 1});
  return found;
}

TEST(FatBorders, ReachAsFarAsTheirWidthAndNoFurther) {
  struct Case {
    PatchSurface surface;
    float right, low;  // of the square
  };
  for (const Case& c : {Case{widened_square(), 3, 1}, Case{widened_patch(), 1, 0}}) {
    const auto scene = prepared(c.surface);
    const float side = c.right - c.low, middle = c.low + 0.4f * side;
    const auto w = static_cast<float>(kWidth);
    // The decision on trims is off by up to 5 u of the square, which widths have on top.
    for (const float share : {0.1f, 0.5f, 0.96f}) {
      const core::CastHit on = hit(*scene, {c.right + share * w, middle, 1}, {0, 0, -1});
      EXPECT_TRUE(on.is_hit) << share;
      EXPECT_NEAR(on.t, 1 + std::sqrt(1 - share * share) * w, 0.03 * kWidth);
      EXPECT_TRUE(hit(*scene, {c.right - 1, middle, share * w}, {1, 0, 0}).is_hit) << share;
      EXPECT_TRUE(hit(*scene, {c.right - 1, middle, -share * w}, {1, 0.5f, 0}).is_hit) << share;
    }
    EXPECT_FALSE(hit(*scene, {c.right + 1.001f * w, middle, 1}, {0, 0, -1}).is_hit);
    EXPECT_FALSE(hit(*scene, {c.right - 1, middle, 1.001f * w}, {1, 0, 0}).is_hit);
    EXPECT_FALSE(hit(*scene, {c.right + 0.5f * w, c.low - w, 1}, {0, 0, -1}).is_hit);
    // Nothing is widened at open edges.
    for (const float share : {0.01f, 0.5f, 0.96f}) {
      EXPECT_FALSE(hit(*scene, {c.low - share * w, middle, 1}, {0, 0, -1}).is_hit) << share;
      EXPECT_FALSE(hit(*scene, {middle, c.right + share * w, 1}, {0, 0, -1}).is_hit) << share;
      EXPECT_FALSE(hit(*scene, {middle, c.low - share * w, 1}, {0, 0, -1}).is_hit) << share;
    }
  }
}

TEST(FatBorders, AreWiderWhereTheirSurfaceIsLarger) {
  Transform twice;
  twice.m = {{{0, -2, 0, 5}, {2, 0, 0, 7}, {0, 0, 2, 9}}};
  const auto scene = prepared(widened_patch(), twice);
  const auto w = static_cast<float>(2 * kWidth);
  // (1, 0.4) of the patch stands at (4.2, 9).
  EXPECT_TRUE(hit(*scene, {4.2f, 9 + 0.96f * w, 10}, {0, 0, -1}).is_hit);
  EXPECT_FALSE(hit(*scene, {4.2f, 9 + 1.002f * w, 10}, {0, 0, -1}).is_hit);
}

TEST(FatBorders, LetRaysGoThatBeginWithin) {
  const auto scene = prepared(widened_square());
  const auto w = static_cast<float>(kWidth);
  EXPECT_FALSE(hit(*scene, {3, 2, 0.001f * w}, {0.3f, 0.1f, 1}).is_hit);
  EXPECT_FALSE(hit(*scene, {3 - 0.5f * w, 2, 0.001f * w}, {1, 0, 1}).is_hit);
  EXPECT_FALSE(hit(*scene, {3 + 0.5f * w, 2, 0.1f * w}, {0, 0, -1}).is_hit);
}

// Rays find the surface itself where it is, in front of its border's reach.
TEST(FatBorders, ComeBehindTheSurface) {
  const auto scene = prepared(widened_square());
  for (const float share : {0.01f, 0.3f, 0.7f}) {
    const core::CastHit on =
        hit(*scene, {3 - share * static_cast<float>(kWidth), 2, 1}, {0, 0, -1});
    ASSERT_TRUE(on.is_hit);
    EXPECT_EQ(on.t, 1);
  }
}

// Half of them in groups of 64 that start from one point and end near each other.
TEST(FatBorders, HaveTheSameBitsForAllBundlesAndInstructionSets) {
  Choices choices(77);
  const Cylinder cylinder(1e-3, choices);
  Transform moved;
  moved.m = {{{0.8f, -0.6f, 0, 3}, {0.6f, 0.8f, 0, -5}, {0, 0, 1, 11}}};
  for (const Transform& to_world : {Transform{}, moved}) {
    const auto scene = prepared(cylinder.surface(), to_world);
    std::vector<core::CastRay> some;
    EdgePlace first_place = cylinder.place(choices);
    Vec3f from;
    for (int i = 0; i < 8192; ++i) {
      const bool is_group = i / 64 % 2 == 0, begins = i % 64 == 0;
      EdgePlace place = cylinder.place(choices);
      while (is_group && !begins && length(place.on[0] - first_place.on[0]) > 0.2)
        place = cylinder.place(choices);
      if (begins) first_place = place;
      const Vec3f at = to_world.point(rounded(place.on[0]) + choices.point(1e-3f));
      if (begins || !is_group) from = to_world.point(choices.point(2));
      some.push_back({from, at - from, 0, Bounds3f::kInf});
    }
    std::optional<std::vector<core::CastHit>> first;
    for (const Isa isa : {Isa::kScalar, Isa::kSse4, Isa::kAvx2, Isa::kAvx512}) {
      if ((core::supported_isas() & isa_bit(isa)) == 0) continue;
      for (const int bundle : {1, 4, 16, 64}) {
        std::vector<core::CastHit> hits(some.size());
        core::CastOptions options;
        options.isa = isa;
        options.bundle = bundle;
        options.threads = bundle == 64 ? 2 : 1;
        cast_rays(*scene, some, options, hits);
        if (!first) first = hits;
        const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
        for (std::size_t i = 0; i < hits.size(); ++i) {
          const core::CastHit &a = hits[i], &b = (*first)[i];
          ASSERT_TRUE(a.is_hit == b.is_hit && a.primitive == b.primitive &&
                      bits(a.t) == bits(b.t) && bits(a.u) == bits(b.u) && bits(a.v) == bits(b.v))
              << isa_name(isa) << ", bundles of " << bundle << ", ray " << i;
        }
      }
    }
  }
}

// Whether a place that is met of a border lies where kernels look for it: in the box of the border
// that stands for it in the hierarchy, and in its frame, near the parabola.
void expect_held(const core::SubPatch& leader, const Bounds3f& box, Vec3f at) {
  constexpr float kOff = 1e-5f;
  double local[3], size[3];
  for (int r = 0; r < 3; ++r) {
    EXPECT_GE(at[r], box.lower[r] - kOff);
    EXPECT_LE(at[r], box.upper[r] + kOff);
    local[r] = size[r] = 0;
    for (int a = 0; a < 3; ++a) {
      local[r] += double{leader.frame[r][a]} * (double{at[a]} - double{leader.centre[a]});
      size[r] += std::fabs(double{leader.frame[r][a]});
    }
    EXPECT_LE(std::fabs(local[r]),
              (r < 2 ? 1 : 0) + double{leader.reach[r]} + double{kOff} * size[r]);
  }
  const double c = leader.second[2][1], y = c * (local[0] * local[0] - 0.5);
  const double off = double{kOff} * (size[1] + 2 * std::fabs(c) * size[0]);
  EXPECT_LE(std::fabs(local[1] - y), double{leader.second[2][2]} + off);
}

// The border that a ray meets first, of those that `parts` stand for.
struct BorderHit {
  float t = Bounds3f::kInf;
  double u = 0, v = 0;
};
BorderHit border_hit(const core::PatchStore& store, std::vector<Bounds3f>& boxes, Vec3f origin,
                     Vec3f direction) {
  BorderHit best;
  for (std::size_t p = 0; p < store.parts.size(); ++p) {
    const core::SubPatch& leader = store.parts[p];
    if (!is_fat_border(leader) || boxes[p].is_empty()) continue;
    for (const core::SubPatch* part = &leader; part != nullptr; part = next_border_beside(*part)) {
      const core::FatHit hit =
          fat_border_hit(store.patches[part->patch], *part, &origin.x, &direction.x, 0);
      if (!hit.is_hit) continue;
      if (hit.t < best.t) best = {hit.t, hit.u, hit.v};
      expect_held(leader, boxes[p], origin + direction * hit.t);
    }
  }
  return best;
}

Scene scene_of(const PatchSurface& surface) {
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {std::make_shared<const PatchSurface>(surface)};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return scene;
}

// Both faces of an edge have its border, of which one stands in the hierarchy: rays meet what they
// would meet were all of them there.
TEST(FatBorders, OfBothFacesAreMetByOneBox) {
  Choices choices(31);
  const Cylinder cylinder(1e-3, choices);
  const Scene scene = scene_of(cylinder.surface());
  std::vector<Bounds3f> boxes;
  const auto store = core::make_patch_store(scene, boxes);
  std::vector<int> times(store.parts.size());
  int borders = 0, leaders = 0;
  for (std::size_t p = 0; p < store.parts.size(); ++p) {
    if (!is_fat_border(store.parts[p])) continue;
    ++borders;
    if (boxes[p].is_empty()) continue;
    ++leaders;
    for (const core::SubPatch* part = &store.parts[p]; part; part = next_border_beside(*part))
      ++times[static_cast<std::size_t>(part - store.parts.data())];
  }
  EXPECT_LT(leaders, 0.7 * borders);
  for (std::size_t p = 0; p < store.parts.size(); ++p)
    EXPECT_EQ(times[p], is_fat_border(store.parts[p]) ? 1 : 0) << p;
  const auto prepared_scene = prepared(cylinder.surface());
  int of_borders = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3f at = rounded(cylinder.place(choices).on[0]) + choices.point(5e-4f);
    const Vec3f from = choices.point(2), along = at - from;
    float t = Bounds3f::kInf;
    bool is_border = false;
    for (const core::SubPatch& part : store.parts) {
      const core::PatchAnswer answer =
          core::patch_answer(store.patches[part.patch], part, &from.x, &along.x, 0);
      if (!answer.is_hit || !(answer.t < t)) continue;
      t = answer.t;
      is_border = is_fat_border(part);
    }
    const core::CastHit found = hit(*prepared_scene, from, along);
    ASSERT_EQ(found.is_hit, t < Bounds3f::kInf) << i;
    ASSERT_TRUE(!found.is_hit || found.t == t) << i;
    of_borders += is_border ? 1 : 0;
  }
  EXPECT_GT(of_borders, 100);
}

TEST(FatBorders, OfSpansThatAreJoinedAreMetWhereTheyAreOneByOne) {
  Choices choices(5);
  const Cylinder cylinder(1e-3, choices);
  const Scene scene = scene_of(cylinder.surface());
  core::PatchSplitting alone, joined;
  joined.borders.run_max = core::kFatRunMax;
  std::vector<Bounds3f> alone_boxes, joined_boxes;
  const auto of_alone = make_patch_store(scene, alone, alone_boxes);
  const auto of_joined = make_patch_store(scene, joined, joined_boxes);
  EXPECT_LT(of_joined.parts.size(), of_alone.parts.size());
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3f at = rounded(cylinder.place(choices).on[0]) + choices.point(5e-4f);
    const Vec3f from = choices.point(2);
    const BorderHit a = border_hit(of_alone, alone_boxes, from, at - from);
    const BorderHit b = border_hit(of_joined, joined_boxes, from, at - from);
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a.t), std::bit_cast<std::uint32_t>(b.t)) << i;
    ASSERT_TRUE(a.u == b.u && a.v == b.v) << i;
    hits += a.t < Bounds3f::kInf ? 1 : 0;
  }
  EXPECT_GT(hits, 1000);
}

// A loop along the border and back trims nothing, and costs no question.
TEST(FatBorders, OfThePatchTrimNothing) {
  const core::TrimSet set(widened_patch());
  EXPECT_FALSE(set.is_trimmed(0));
  EXPECT_EQ(set.kept_of(0, {0, 1, 0, 1}), core::Kept::kAll);
  const auto [first, end] = set.borders().of_patch(0);
  EXPECT_LT(first, end);
  const core::TrimSet none(test::plain_patch(true));
  EXPECT_EQ(none.borders().of_patch(0).end, 0u);
}

}  // namespace
}  // namespace tessera
