// SPDX-License-Identifier: Apache-2.0
// Property: no point of a part of a trimming segment on its patch is further from that of the
// part's chord than is said, and for what is straight or small little is said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/segment_bend.h"
#include "tests/support/choices.h"
#include "tests/support/patch_shapes.h"

namespace tessera::core {
namespace {

using test::Choices;

// A segment with its coefficients, as a whole part.
struct Segment {
  int degree = 1;
  TrimCoefficient coefficients[kTrimDegreeMax + 1];
  TrimPart whole;

  void set(int index, TrimPoint point) {
    coefficients[index] = coefficient_of(point, degree, index);
    const double w = point.weight;
    whole.net[index] = {w * double{point.u}, w * double{point.v}, w};
  }
};

Segment line(float u0, float v0, float u1, float v1) {
  Segment made;
  made.set(0, {u0, v0, 1});
  made.set(1, {u1, v1, 1});
  return made;
}

Segment any_segment(Choices& choices) {
  Segment made;
  made.degree = 1 + static_cast<int>(choices.below(9));
  const float size = choices.power(-3, 0), u = (1 - size) * choices.share(),
              v = (1 - size) * choices.share();
  const bool is_rational = choices.one_in(2);
  for (int i = 0; i <= made.degree; ++i)
    made.set(i, {u + size * choices.share(), v + size * choices.share(),
                 is_rational ? choices.power(-0.5f, 0.5f) : 1});
  return made;
}

Vec3d point_of(const Patch& patch, const Segment& segment, double t) {
  const TrimPlace place = point_at(segment.coefficients, segment.degree, {1 - t, t});
  const PatchJet jet = evaluate(patch, place.u, place.v);
  return {jet.point[0], jet.point[1], jet.point[2]};
}

// The most that points of a part are away from those of its chord.
double true_distance(const Patch& patch, const Segment& segment, const TrimPart& part) {
  const Vec3d from = point_of(patch, segment, part.from.t),
              to = point_of(patch, segment, part.to.t);
  double most = 0;
  for (int i = 1; i < 32; ++i) {
    const double share = i / 32.0;
    const double t = part.from.t + share * (part.to.t - part.from.t);
    const Vec3d on_chord = from + share * (to - from);
    most = std::max(most, length(point_of(patch, segment, t) - on_chord));
  }
  return most;
}

TEST(SegmentBend, HoldsAllPointsOfAllParts) {
  Choices choices(501);
  int tight = 0, count = 0;
  for (const char* shape : {"sphere", "cylinder", "cone", "torus", "teapot", "plane", "cusp",
                            "degree15x9", "weights", "weights4x5"}) {
    for (const CheckedPatch& checked : test::patch_shape(shape)) {
      const Patch patch = checked.patch();
      const SegmentBend bend(patch);
      for (int n = 0; n < 40; ++n) {
        const Segment segment = any_segment(choices);
        TrimPart part = segment.whole;
        for (unsigned halves = choices.below(5); halves > 0; --halves) {
          const TrimPart half = first_half(part, segment.degree);
          if (choices.one_in(2)) part = half;
        }
        const double away = bend.away_from_chord(part, segment.degree);
        const double seen = true_distance(patch, segment, part);
        EXPECT_LE(seen, away + 0x1p-40 * patch.extent) << shape << " " << n;
        ++count;
        tight += away <= 8 * seen + 0x1p-24 * patch.extent ? 1 : 0;
      }
    }
  }
  std::printf("%d of %d are told to a factor of 8\n", tight, count);
  EXPECT_GE(2 * tight, count);
}

// Sides of cylinders are straight, and small arcs of large ones nearly so: what is said of them is
// what decides into how many spans they are cut.
TEST(SegmentBend, SaysLittleOfWhatIsStraight) {
  for (const CheckedPatch& checked : test::patch_shape("cylinder")) {
    const Patch patch = checked.patch();
    if (!patch.is_rational) continue;
    const SegmentBend bend(patch);
    for (const float at : {0.0f, 0.3f, 1.0f}) {
      for (const bool along_u : {false, true}) {
        const Segment whole = along_u ? line(0, at, 1, at) : line(at, 0, at, 1);
        const double seen = true_distance(patch, whole, whole.whole);
        EXPECT_LE(bend.away_from_chord(whole.whole, 1), 8 * seen + 0x1p-18 * patch.extent);
        const Segment arc = along_u ? line(0.5f, at, 0.51f, at) : line(at, 0.5f, at, 0.51f);
        EXPECT_LE(bend.away_from_chord(arc.whole, 1),
                  4 * true_distance(patch, arc, arc.whole) + 0x1p-18 * patch.extent);
      }
    }
  }
}

// The border of a patch that is one point is no curve.
TEST(SegmentBend, SaysNothingOfACollapsedBorder) {
  for (const CheckedPatch& checked : test::patch_shape("sphere")) {
    const Patch patch = checked.patch();
    const SegmentBend bend(patch);
    for (const Segment& side :
         {line(0, 0, 1, 0), line(1, 0, 1, 1), line(0, 1, 1, 1), line(0, 0, 0, 1)}) {
      if (length(point_of(patch, side, 0) - point_of(patch, side, 1)) > 0x1p-20) continue;
      EXPECT_LE(bend.away_from_chord(side.whole, 1), 0x1p-18 * patch.extent);
    }
  }
}

}  // namespace
}  // namespace tessera::core
