// SPDX-License-Identifier: Apache-2.0
// Property: the parts of a patch tile it, their boxes hold their part of the surface, and in the
// frame of each the surface and its second derivatives are within the bounds that are stored, over
// the square and what is allowed beyond it, in extended precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_preparation.h"
#include "slave/core/primitive/patch/placed_sub_patch.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "tests/support/choices.h"
#include "tests/support/patch_reference.h"
#include "tests/support/patch_shapes.h"
#include "tests/support/seed.h"

namespace tessera {
namespace {

using core::SubPatch;
using core::SubPatchRange;
using Long = long double;

const char* const kShapes[] = {"sphere", "torus",   "cylinder",   "cone",
                               "teapot", "plane",   "cusp",       "fold",
                               "sheets", "plane33", "degree15x9", "weights4x5"};

// A value in the square, now and then on or beyond its border.
double place(test::Choices& any) {
  if (any.one_in(4))
    return (any.one_in(2) ? 1 : -1) * (1 + (any.one_in(2) ? core::kSquareWiden : 0));
  return double{any.sign()};
}

void expect_within(const core::Patch& patch, const SubPatch& part, double x, double y) {
  const SubPatchRange range(part);
  const Long u = range.middle_u + Long(range.half_u) * x,
             v = range.middle_v + Long(range.half_v) * y;
  const test::LongJet jet = test::long_jet(patch, u, v);
  const core::PatchCurvature bend =
      core::second_derivatives(patch, static_cast<double>(u), static_cast<double>(v));
  for (int r = 0; r < 3; ++r) {
    Long local = 0, xx = 0, xy = 0, yy = 0, noise = 0;
    for (int k = 0; k < 3; ++k) {
      const Long f = part.frame[r][k];
      local += f * (jet.point[k] - part.centre[k]);
      xx += f * bend.duu[k] * range.half_u * range.half_u;
      xy += f * bend.duv[k] * range.half_u * range.half_v;
      yy += f * bend.dvv[k] * range.half_v * range.half_v;
      // Of second derivatives, which double gives: terms up to 4 d^2 of the extent, as weights here
      // differ by less than 2, and the extent is some of the largest coordinate.
      noise += std::fabs(f) * (4 * 225 * 4) * Long(core::plain::kEvaluationError) * patch.extent;
    }
    noise *= std::max(range.half_u, range.half_v) * std::max(range.half_u, range.half_v);
    const Long rest = local - (r == 0 ? x : r == 1 ? y : 0);
    ASSERT_LE(std::fabs(rest), Long(part.reach[r])) << "row " << r << " at " << x << " " << y;
    ASSERT_LE(std::fabs(xx), part.second[0][r] + noise);
    ASSERT_LE(std::fabs(xy), part.second[1][r] + noise);
    ASSERT_LE(std::fabs(yy), part.second[2][r] + noise);
  }
}

TEST(PatchPreparation, BoundsHold) {
  test::Choices any(20086);
  for (const char* name : kShapes) {
    SCOPED_TRACE(name);
    for (const float shift : {0.0f, 1000.0f}) {
      const test::PatchScene scene(test::moved(test::patch_shape(name), 1, shift));
      const auto& parts = scene.parts().parts;
      for (std::size_t k = 0; k < parts.size(); k += 1 + any.below(4)) {
        if (!parts[k].has_frame) continue;
        for (int point = 0; point < 12; ++point) {
          expect_within(scene.patch(parts[k].patch), parts[k], place(any), place(any));
          if (HasFatalFailure()) return;
        }
      }
    }
  }
}

TEST(PatchPreparation, BoxesHoldTheirParts) {
  test::Choices any(20087);
  for (const char* name : kShapes) {
    SCOPED_TRACE(name);
    const test::PatchScene scene(test::patch_shape(name));
    for (std::size_t k = 0; k < scene.parts().parts.size(); ++k) {
      const SubPatch& part = scene.parts().parts[k];
      const SubPatchRange range(part);
      const Bounds3f& box = scene.parts().boxes[k];
      for (int point = 0; point < 6; ++point) {
        const double x = std::clamp(place(any), -1.0, 1.0), y = std::clamp(place(any), -1.0, 1.0);
        const test::LongJet jet =
            test::long_jet(scene.patch(part.patch), range.middle_u + Long(range.half_u) * x,
                           range.middle_v + Long(range.half_v) * y);
        for (int a = 0; a < 3; ++a) {
          ASSERT_LE(box.lower[a], jet.point[a]);
          ASSERT_GE(box.upper[a], jet.point[a]);
        }
      }
    }
  }
}

// Maps that turn, mirror, shear and scale.
Transform any_map(test::Choices& any) {
  Transform map;
  const float size = std::ldexp(1.0f, static_cast<int>(any.below(41)) - 20);
  for (auto& row : map.m) {
    for (std::size_t k = 0; k < 3; ++k) row[k] = size * any.sign();
    row[3] = any.one_in(3) ? 0 : 100 * size * any.sign();
  }
  if (any.one_in(4)) {  // lines that stay parallel to axes
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) map.m[i][k] = i == k ? size : 0;
  }
  if (any.one_in(4)) {  // a sheet, by and by
    for (std::size_t k = 0; k < 3; ++k)
      map.m[2][k] = map.m[1][k] + std::ldexp(map.m[2][k], -static_cast<int>(any.below(16)));
  }
  return map;
}

std::vector<core::CheckedPatch> placed(const std::vector<core::CheckedPatch>& patches,
                                       const Transform& map) {
  std::vector<core::CheckedPatch> to;
  for (const core::CheckedPatch& patch : patches) {
    std::vector<float> numbers = patch.numbers;
    for (std::size_t k = 0; k < numbers.size(); k += patch.is_rational ? 4 : 3) {
      const Vec3f at = map.point({numbers[k], numbers[k + 1], numbers[k + 2]});
      for (int a = 0; a < 3; ++a) numbers[k + static_cast<std::size_t>(a)] = at[a];
    }
    to.push_back(
        core::checked_patch({patch.degree_u, patch.degree_v, patch.is_rational, numbers}).value());
  }
  return to;
}

Bounds3f box_of(const core::CheckedPatch& patch) {
  Bounds3f box;
  for (std::size_t k = 0; k < patch.numbers.size(); k += patch.is_rational ? 4 : 3)
    box.grow(Vec3f{patch.numbers[k], patch.numbers[k + 1], patch.numbers[k + 2]});
  return box;
}

// Parts that are brought to another place keep bounds and boxes that hold, and nearly all of them
// their frames.
TEST(PatchPreparation, BoundsHoldInOtherPlaces) {
  test::Choices any(test::seed(20091));
  std::size_t framed = 0, lost = 0;
  double grown = 0;
  for (const char* name : kShapes) {
    SCOPED_TRACE(name);
    const std::vector<core::CheckedPatch> patches = test::patch_shape(name);
    const test::PatchScene scene(patches);
    for (int round = 0; round < 12; ++round) {
      const Transform map = any_map(any);
      const std::vector<core::CheckedPatch> there = placed(patches, map);
      core::PatchPlacement placement(map);
      std::uint32_t known = 0xffffffffu;
      for (std::size_t k = 0; k < scene.parts().parts.size(); k += 1 + any.below(16)) {
        const SubPatch& part = scene.parts().parts[k];
        if (part.patch != known) placement.take(scene.patch(part.patch), box_of(there[part.patch]));
        known = part.patch;
        Bounds3f box = scene.parts().boxes[k];
        const SubPatch moved = placement.placed(part, box);
        ++(moved.has_frame ? framed : lost);
        if (part.has_frame == moved.has_frame && part.reach[2] > 0)
          grown = std::max(grown, double{moved.reach[2]} - double{part.reach[2]});
        const SubPatchRange range(moved);
        for (int point = 0; point < 6; ++point) {
          const double x = place(any), y = place(any);
          const test::LongJet jet =
              test::long_jet(there[part.patch].patch(),
                             range.middle_u + Long(range.half_u) * std::clamp(x, -1., 1.),
                             range.middle_v + Long(range.half_v) * std::clamp(y, -1., 1.));
          for (int a = 0; a < 3; ++a) {
            ASSERT_LE(box.lower[a], jet.point[a]);
            ASSERT_GE(box.upper[a], jet.point[a]);
          }
          if (moved.has_frame) expect_within(there[part.patch].patch(), moved, x, y);
          if (HasFatalFailure()) return;
        }
      }
    }
  }
  EXPECT_LT(lost, framed / 10);
  std::cout << framed << " parts with frames, " << lost << " without, grown by " << grown << "\n";
}

TEST(PatchPreparation, PartsTileTheirPatch) {
  for (const char* name : kShapes)
    for (const double radius : {0.2, 0.5, 2.0}) {
      core::PatchSplitting splitting;
      splitting.radius = radius;
      const test::PatchScene scene(test::patch_shape(name), splitting);
      ASSERT_EQ(scene.parts().parts.size(), scene.parts().boxes.size());
      const std::size_t side = std::size_t{1} << splitting.level_max;
      std::vector<int> covered(scene.patch_count() * side * side);
      std::uint32_t last = 0;
      for (const SubPatch& part : scene.parts().parts) {
        ASSERT_GE(part.patch, last);  // numbers run in the order of patches
        last = part.patch;
        const std::size_t width = side >> part.level_u, height = side >> part.level_v;
        for (std::size_t i = 0; i < width; ++i)
          for (std::size_t j = 0; j < height; ++j)
            ++covered.at((part.patch * side + part.column * width + i) * side + part.row * height +
                         j);
      }
      EXPECT_EQ(std::count(covered.begin(), covered.end(), 1),
                static_cast<std::ptrdiff_t>(covered.size()))
          << name;
    }
}

// The frame leaves open what was asked for, unless the part is as small as parts become.
TEST(PatchPreparation, PlanesAreNotSplit) {
  EXPECT_EQ(test::PatchScene(test::patch_shape("plane")).parts().parts.size(), 1u);
  EXPECT_EQ(test::PatchScene(test::patch_shape("plane33")).parts().parts.size(), 1u);
}

// A part that holds a point of a weight that is far below the others has no bounds.
TEST(PatchPreparation, PartsOfWeightsThatAreFarApartAreNoBorders) {
  const float numbers[] = {0, 0, 0, 1e-30f, 0, 1, 0, 1, 1, 0, 0, 1, 1, 1, 0.5f, 1};
  const auto checked = core::checked_patch({1, 1, true, numbers});
  ASSERT_TRUE(checked.is_ok());
  core::SubPatches split;
  core::split_patch(checked->patch(), 0, core::PatchSplitting(), split);
  int without_frame = 0;
  for (const SubPatch& part : split.parts) {
    without_frame += part.has_frame ? 0 : 1;
    EXPECT_FALSE(core::is_fat_border(part));
  }
  EXPECT_GT(without_frame, 0);
}

}  // namespace
}  // namespace tessera
