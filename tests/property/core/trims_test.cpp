// SPDX-License-Identifier: Apache-2.0
// Property: of every point further than 4 u (u = 2^-24) from all trimming loops of a patch, it is
// answered rightly whether the loops keep it, for all classes of loops that are hard; and loops
// elsewhere cost nothing. TESSERA_LONG=1 asks for ten times as many points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <optional>
#include <ostream>
#include <utility>
#include <vector>

#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_preparation.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "slave/core/primitive/patch/trim_set.h"
#include "tests/support/choices.h"
#include "tests/support/trim_reference.h"
#include "tests/support/trim_shapes.h"

namespace tessera {
namespace {

using core::TrimPlace;
using core::TrimSet;
using core::TrimSteps;
using test::TrimAsk;
using test::TrimClass;

constexpr double kTolerance = 4 * 0x1p-24;

int asks(int few) { return std::getenv("TESSERA_LONG") == nullptr ? few : 10 * few; }

struct Class {
  const char* name;
  TrimClass kind;
  int scenes;
};
void PrintTo(const Class& c, std::ostream* out) { *out << c.name; }

struct Counts {
  int far = 0, near = 0, wrong = 0, kept = 0;
  TrimSteps steps;

  void add(const Counts& other) {
    far += other.far;
    near += other.near;
    wrong += other.wrong;
    kept += other.kept;
    steps.pieces += other.steps.pieces;
    steps.points += other.steps.points;
  }
  double pieces() const { return static_cast<double>(steps.pieces) / (far + near); }
  double points() const { return static_cast<double>(steps.points) / (far + near); }
};

// Asks one patch and the reference.
class Judge {
 public:
  Judge(const PatchSurface& surface, const core::TrimCellOptions& options)
      : set_(surface, options), reference_(surface, 0, kTolerance) {}

  bool answer(const TrimAsk& at) const { return set_.is_kept(0, at.u, at.v); }

  // Points too near to a loop are right in any case.
  bool is_right(const TrimAsk& at) {
    const std::optional<bool> right = reference_.is_kept(at.u, at.v);
    const bool answer = set_.is_kept(0, at.u, at.v, counts_.steps);
    remember({at.u, at.v});
    if (!right.has_value()) {
      ++counts_.near;
      return true;
    }
    ++counts_.far;
    counts_.kept += *right;
    if (answer == *right) return true;
    ++counts_.wrong;
    return false;
  }

  // The v of an end of a piece: of a segment, or where u or v turns.
  double level(test::Choices& choices) const {
    const auto& pieces = set_.cells().pieces;
    if (pieces.empty()) return 0.5;  // a loop that is one point
    const unsigned chosen = choices.below(2 * static_cast<unsigned>(pieces.size()));
    return pieces[chosen / 2].v[chosen % 2];
  }

  // Points that were asked since the last call, on cells' borders, too, are answered together as
  // each alone. Returns: how many are not.
  int differences() {
    const std::uint64_t bits = set_.kept(0, asked_);
    int differ = 0;
    for (std::size_t i = 0; i < asked_.size(); ++i)
      differ += ((bits >> i & 1) != 0) != set_.is_kept(0, asked_[i].u, asked_[i].v);
    asked_.clear();
    return differ;
  }
  bool is_full() const { return asked_.size() == core::kTrimPlacesMax; }

  const Counts& counts() const { return counts_; }

 private:
  // Some are moved to a border of the cells of masks, or beside it.
  void remember(TrimPlace at) {
    if (is_full()) return;
    const std::size_t kind = asked_.size() % 8;
    if (kind < 3) {
      at.u = std::round(16 * at.u) / 16;
      if (kind > 0) at.u = std::nextafter(at.u, kind == 1 ? 2.0 : -1.0);
    }
    asked_.push_back(at);
  }

  std::vector<TrimPlace> asked_;
  const TrimSet set_;
  test::TrimReference reference_;
  Counts counts_;
};

class Trims : public testing::TestWithParam<Class> {};

TEST_P(Trims, EveryPointAwayFromTheLoopsIsRight) {
  const Class& c = GetParam();
  test::Choices choices(100 + static_cast<unsigned>(c.kind));
  Counts all;
  int differ = 0;
  for (int scene = 0; scene < c.scenes; ++scene) {
    test::TrimShapes shapes(c.kind, choices);
    // With fewer cells crowds are asked in their order.
    core::TrimCellOptions options;
    if (c.kind == TrimClass::kCrowd) options = {1, 2, 64};
    Judge judge(shapes.surface(), options);
    const int wanted = asks(100'000) / c.scenes;
    for (int i = 0; i < 4 * wanted && judge.counts().far < wanted; ++i) {
      TrimAsk at = shapes.ask();
      if (i % 8 == 0) at.v = judge.level(choices);
      if (judge.is_full()) differ += judge.differences();
      if (judge.is_right(at) || all.wrong + judge.counts().wrong > 3) continue;
      ADD_FAILURE() << "scene " << scene << ": (" << std::hexfloat << at.u << ", " << at.v
                    << ") is " << (judge.answer(at) ? "left out" : "kept");
    }
    all.add(judge.counts());
  }
  EXPECT_EQ(all.wrong, 0) << "of " << all.far;
  EXPECT_EQ(differ, 0);
  // What says nothing tests nothing.
  EXPECT_GE(all.far, asks(100'000) * 9 / 10);
  EXPECT_GT(all.kept, all.far / 100);
  EXPECT_LT(all.kept, all.far - all.far / 100);
  std::cout << c.name << ": " << all.far << " points, " << all.near << " too near; " << all.pieces()
            << " pieces and " << all.points() << " points of them a query\n";
}

INSTANTIATE_TEST_SUITE_P(
    All, Trims,
    testing::Values(
        Class{"smooth", TrimClass::kSmooth, 100}, Class{"level", TrimClass::kLevel, 100},
        Class{"cusps", TrimClass::kCusps, 100}, Class{"touching", TrimClass::kTouching, 20},
        Class{"tiny", TrimClass::kTiny, 50}, Class{"nested", TrimClass::kNested, 20},
        Class{"border", TrimClass::kBorder, 100}, Class{"strips", TrimClass::kStrips, 100},
        Class{"many", TrimClass::kMany, 20}, Class{"degrees", TrimClass::kDegrees, 100},
        Class{"weights", TrimClass::kWeights, 100}, Class{"wild", TrimClass::kWildWeights, 100},
        Class{"crossing", TrimClass::kCrossing, 100}, Class{"crowd", TrimClass::kCrowd, 20}),
    [](const testing::TestParamInfo<Class>& of) { return of.param.name; });

// What is said of a rectangle holds for all of its points.
TEST_P(Trims, EveryPointOfAnAreaIsWhatTheAreaIs) {
  const Class& c = GetParam();
  test::Choices choices(300 + static_cast<unsigned>(c.kind));
  int decided = 0, wrong = 0;
  for (int scene = 0; scene < c.scenes; ++scene) {
    test::TrimShapes shapes(c.kind, choices);
    core::TrimCellOptions options;
    if (c.kind == TrimClass::kCrowd) options = {1, 2, 64};
    const TrimSet set(shapes.surface(), options);
    for (int i = 0; i < asks(10'000) / c.scenes; ++i) {
      const TrimAsk corner = shapes.ask();
      const double width = double{choices.power(-4, -1)}, height = double{choices.power(-4, -1)};
      const core::TrimArea area{corner.u, std::min(1.0, corner.u + width), corner.v,
                                std::min(1.0, corner.v + height)};
      const core::Kept kept = set.kept_of(0, area);
      if (kept == core::Kept::kSome) continue;
      ++decided;
      for (int k = 0; k < 8; ++k) {
        const double u = area.u0 + double{choices.share()} * (area.u1 - area.u0);
        const double v = area.v0 + double{choices.share()} * (area.v1 - area.v0);
        wrong += set.is_kept(0, u, v) != (kept == core::Kept::kAll);
      }
    }
  }
  EXPECT_EQ(wrong, 0) << "in " << decided << " areas";
  EXPECT_GT(decided, asks(10'000) / 50);
}

// Loops beside each other, with as much room for each; or one in the other; or tall and thin.
enum class Layout { kBeside, kNested, kStrips };

PatchSurface layout(Layout of, int loops) {
  PatchSurface surface = test::plain_patch(true);
  const int side = static_cast<int>(std::ceil(std::sqrt(loops)));
  for (int i = 0; i < loops; ++i) {
    const float cell = 1 / static_cast<float>(of == Layout::kBeside ? side : loops);
    const auto at = [&](int place) { return (static_cast<float>(place) + 0.5f) * cell; };
    if (of == Layout::kBeside) {
      test::add_circle(surface, at(i % side), at(i / side), 0.3f * cell);
    } else if (of == Layout::kNested) {
      test::add_circle(surface, 0.5f, 0.5f, 0.5f * at(i));
    } else {
      test::add_rectangle(surface, at(i) - 0.3f * cell, 0.1f, at(i) + 0.3f * cell, 0.9f);
    }
  }
  return surface;
}

// Parts of a trimmed plane: where the patch is kept there is one, and what is not marked is kept.
TEST_P(Trims, PartsCoverWhatIsKept) {
  const std::vector<float> plane = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0};
  const auto checked = core::checked_patch({1, 1, false, plane});
  ASSERT_TRUE(checked.is_ok());
  test::Choices choices(77);
  int dropped = 0, unmarked = 0;
  for (int scene = 0; scene < GetParam().scenes; ++scene) {
    test::TrimShapes shapes(GetParam().kind, choices);
    const TrimSet set(shapes.surface());
    if (!set.is_trimmed(0)) continue;
    core::Patch patch = checked->patch();
    patch.trims = &set;
    core::SubPatches parts;
    core::split_trimmed_patch(patch, 0, {.trim_level_max = 4}, parts);
    for (int i = 0; i < 200; ++i) {
      const TrimAsk at = shapes.ask();
      const bool is_kept = set.is_kept(0, at.u, at.v);
      bool has_part = false;
      for (const core::SubPatch& part : parts.parts) {
        const core::SubPatchRange range(part);
        if (std::fabs(at.u - range.middle_u) > range.half_u) continue;
        if (std::fabs(at.v - range.middle_v) > range.half_v) continue;
        has_part = true;
        unmarked += !part.is_trimmed;
        ASSERT_TRUE(part.is_trimmed || is_kept) << at.u << " " << at.v;
      }
      ASSERT_TRUE(has_part || !is_kept) << at.u << " " << at.v;
      dropped += !has_part;
    }
  }
  std::cout << dropped << " points without a part, " << unmarked << " in parts that ask nothing\n";
}

// What a point costs in the mean: cells, pieces and points of pieces.
double steps_of(const TrimSet& set) {
  test::Choices choices(7);
  TrimSteps steps;
  constexpr int kAsks = 20'000;
  for (int i = 0; i < kAsks; ++i)
    (void)set.is_kept(0, double{choices.share()}, double{choices.share()}, steps);
  return static_cast<double>(steps.cells + steps.pieces + steps.points) / kAsks;
}

TEST(TrimSteps, AThousandLoopsCostLittleMoreThanOne) {
  for (const auto& [of, most] : {std::pair{Layout::kBeside, 2.0}, std::pair{Layout::kStrips, 2.0},
                                 std::pair{Layout::kNested, 6.0}}) {
    const double one = steps_of(TrimSet(layout(of, 1)));
    const TrimSet many(layout(of, 1000));
    EXPECT_LT(steps_of(many), most * one);
    std::cout << "one loop " << one << ", 1,000 loops " << steps_of(many)
              << " steps; bytes a segment " << static_cast<double>(many.loops().bytes()) / 4000
              << "\n";
  }
}

TEST(TrimSet, PatchesHaveLoopsOfTheirOwn) {
  PatchSurface surface = test::plain_patch(false);
  test::add_rectangle(surface, 0.25f, 0.25f, 0.75f, 0.75f);
  for (const bool keeps_outside : {false, true, true}) {
    surface.patches.push_back(surface.patches[0]);
    surface.patches.back().keeps_outside = keeps_outside ? 1 : 0;
    surface.loop_counts.push_back(0);
  }
  test::add_circle(surface, 0.5f, 0.5f, 0.25f);
  const TrimSet set(surface);
  const bool kept[4][2] = {{true, false}, {true, true}, {true, true}, {false, true}};
  for (std::uint32_t p = 0; p < 4; ++p) {
    EXPECT_EQ(set.is_trimmed(p), p == 0 || p == 3);
    EXPECT_EQ(set.is_kept(p, 0.5, 0.5), kept[p][0]) << p;
    EXPECT_EQ(set.is_kept(p, 0.1, 0.9), kept[p][1]) << p;
  }
  EXPECT_FALSE(TrimSet(test::plain_patch(true)).is_trimmed(0));
  EXPECT_FALSE(TrimSet().is_trimmed(0));
  EXPECT_TRUE(TrimSet().is_kept(0, 0.5, 0.5));
}

TEST(TrimLoopLibrary, SurfacesWithTheSameLoopsShareThem) {
  const PatchSurface surface = layout(Layout::kNested, 3);
  PatchSurface elsewhere = surface, inverse = surface;
  for (float& number : elsewhere.numbers) number += 5;
  elsewhere.trim_widths.assign(surface.degrees.size(), 0.1f);
  inverse.patches[0].keeps_outside ^= 1;
  const PatchSurface other = layout(Layout::kNested, 4);
  core::TrimLoopLibrary library;
  const auto loops = library.of(surface);
  EXPECT_EQ(library.of(elsewhere), loops);
  EXPECT_NE(library.of(inverse), loops);
  EXPECT_NE(library.of(other), loops);
  EXPECT_EQ(library.of(PatchSurface(surface)), loops);
  const TrimSet shared(elsewhere, loops, {}), own(surface);
  EXPECT_LT(shared.borders().of_patch(0).first, shared.borders().of_patch(0).end);
  EXPECT_EQ(own.borders().of_patch(0).end, 0u);
  test::Choices choices(11);
  for (int i = 0; i < 1000; ++i) {
    const double u{choices.share()}, v{choices.share()};
    EXPECT_EQ(shared.is_kept(0, u, v), own.is_kept(0, u, v));
  }
}

// Anywhere, or near each other, so that all lie in one cell, with pieces or without.
TEST(TrimSet, SeveralPointsAreAnsweredAsEachAlone) {
  test::Choices choices(9);
  for (const int loops : {2, 40}) {
    const TrimSet set(layout(Layout::kNested, loops));
    std::uint64_t any = 0, every = ~std::uint64_t{0};
    for (int group = 0; group < 200; ++group) {
      const double width = group % 2 == 0 ? 1 : 0x1p-7;
      const double u = (1 - width) * double{choices.share()};
      const double v = (1 - width) * double{choices.share()};
      std::vector<TrimPlace> places;
      for (int i = 0; i < 64; ++i)
        places.push_back(
            {u + width * double{choices.share()}, v + width * double{choices.share()}});
      const std::uint64_t bits = set.kept(0, places);
      for (std::size_t i = 0; i < places.size(); ++i)
        ASSERT_EQ((bits >> i & 1) != 0, set.is_kept(0, places[i].u, places[i].v)) << group;
      any |= bits;
      every &= bits;
    }
    EXPECT_NE(any, 0u);
    EXPECT_NE(~every, 0u);
  }
}

TEST(TrimSet, WhatIsNotInTheSquareCountsAsTheNearestPoint) {
  PatchSurface surface = test::plain_patch(false);
  test::add_rectangle(surface, 0.5f, 0, 1, 1);
  const TrimSet set(surface);
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double low : {-kInf, -1.0, -0.0, nan}) EXPECT_FALSE(set.is_kept(0, low, 0.5));
  EXPECT_EQ(set.is_kept(0, 0.75, nan), set.is_kept(0, 0.75, 0));
  EXPECT_EQ(set.is_kept(0, 7, 0.5), set.is_kept(0, 1, 0.5));
  EXPECT_EQ(set.is_kept(0, kInf, 0.5), set.is_kept(0, 1, 0.5));
  const std::vector<TrimPlace> places{{-kInf, 0.5}, {nan, 0.5}, {0.75, nan}, {7, 0.5}, {kInf, nan}};
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_EQ((set.kept(0, places) >> i & 1) != 0, set.is_kept(0, places[i].u, places[i].v)) << i;
}

}  // namespace
}  // namespace tessera
