// SPDX-License-Identifier: Apache-2.0
// Property: solids of trimmed patches whose faces were made to gape leak nowhere.
// TESSERA_LONG=1 casts ten times as many rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <utility>

#include "tests/support/closed_solid.h"
#include "tests/support/gaping_solids.h"

namespace tessera {
namespace {

using test::Choices;
using test::Cylinder;
using test::EdgePlace;
using test::SolidWriter;

std::size_t rays(std::size_t few) {
  return std::getenv("TESSERA_LONG") == nullptr ? few : 10 * few;
}

Vec3d axis_of(int axis, double size) {
  return {axis == 0 ? size : 0, axis == 1 ? size : 0, axis == 2 ? size : 0};
}

// A box from 0 to 1 of six planes, each moved out or in, with its sides, by half the gap at most.
class Box {
 public:
  Box(double gap, bool has_borders, Choices& choices) {
    for (int f = 0; f < 6; ++f) {
      for (double& x : off_[f]) x = 0.5 * gap * double{choices.sign()};
    }
    for (int f = 0; f < 6; ++f) add_face(f, has_borders);
  }

  const PatchSurface& surface() const { return writer_.surface(); }

  EdgePlace place(Choices& choices) const {
    while (true) {
      const int f = static_cast<int>(choices.below(6)), g = static_cast<int>(choices.below(6));
      if (f / 2 == g / 2) continue;
      const double share = double{choices.share()};
      EdgePlace place;
      place.on[0] = on_edge(f, g, share);
      place.on[1] = on_edge(g, f, share);
      place.normal[0] = axis_of(f / 2, f % 2 == 0 ? -1 : 1);
      place.normal[1] = axis_of(g / 2, g % 2 == 0 ? -1 : 1);
      return place;
    }
  }

 private:
  static double end_of(int face) { return face % 2; }
  static double& member(Vec3d& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  // Where face f ends at face g.
  double side_of(int f, int g) const { return end_of(g) + off_[f][g]; }

  // A point of the border of face f along face g, from one end to the other.
  Vec3d on_edge(int f, int g, double share) const {
    const int along = 3 - f / 2 - g / 2;
    Vec3d p;
    member(p, f / 2) = end_of(f) + off_[f][f];
    member(p, g / 2) = side_of(f, g);
    const double low = side_of(f, 2 * along), high = side_of(f, 2 * along + 1);
    member(p, along) = low + share * (high - low);
    return p;
  }
  double width_of(int f, int g) const {
    return std::max(length(on_edge(f, g, 0) - on_edge(g, f, 0)),
                    length(on_edge(f, g, 1) - on_edge(g, f, 1)));
  }

  // The plane goes on beyond the box, where a loop trims it; or it ends there itself.
  void add_face(int f, bool has_borders) {
    const int a = f / 2, b = f % 2 == 0 ? (a + 2) % 3 : (a + 1) % 3, c = 3 - a - b;
    const double b0 = side_of(f, 2 * b), b1 = side_of(f, 2 * b + 1);
    const double c0 = side_of(f, 2 * c), c1 = side_of(f, 2 * c + 1);
    const int sides[4] = {2 * c, 2 * b + 1, 2 * c + 1, 2 * b};
    double widths[4];
    for (int k = 0; k < 4; ++k) widths[k] = width_of(f, sides[k]);
    const double beyond = has_borders ? 0 : 0.25;
    const double from_b = has_borders ? b0 : -beyond, to_b = has_borders ? b1 : 1 + beyond;
    const double from_c = has_borders ? c0 : -beyond, to_c = has_borders ? c1 : 1 + beyond;
    Vec3d corner = axis_of(a, end_of(f) + off_[f][f]);
    member(corner, b) = from_b;
    member(corner, c) = from_c;
    writer_.add_plane(corner, axis_of(b, to_b - from_b), axis_of(c, to_c - from_c));
    if (has_borders) {
      const TrimPoint corners[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
      for (int k = 0; k < 4; ++k) writer_.add_side(corners[k], corners[(k + 1) % 4], widths[k]);
      return;
    }
    writer_.keep_inside();
    const auto u = [&](double x) { return (x - from_b) / (to_b - from_b); };
    const auto v = [&](double x) { return (x - from_c) / (to_c - from_c); };
    writer_.add_rectangle(u(b0), v(c0), u(b1), v(c1), widths);
  }

  SolidWriter writer_;
  double off_[6][6];  // of a face's plane, and of its ends at others
};

// Returns: leaks with the widths, and without.
template <class Solid>
std::pair<std::size_t, std::size_t> leaks(const Solid& solid, double gap, std::size_t count,
                                          Choices& choices) {
  const auto place = [&] { return solid.place(choices); };
  const double reach = 4 * (gap + 0x1p-20);
  PatchSurface without = solid.surface();
  without.trim_widths.clear();
  const test::ClosedSolid closed(solid.surface(), 1.7, reach), open(without, 1.7, reach);
  return {closed.cast(place, count, choices).leaks, open.cast(place, count, choices).leaks};
}

TEST(ClosedSolids, OfFacesThatGapeHaveNoLeaks) {
  Choices choices(1912);
  for (const double gap : {1e-3, 1e-4, 1e-6, 1e-9}) {
    std::size_t with = 0, without = 0;
    const std::size_t count = rays(4'000);
    for (int k = 0; k < 3; ++k) {
      for (const bool has_borders : {false, true}) {
        const Box box(gap, has_borders, choices);
        const auto [closed, open] = leaks(box, gap, count, choices);
        with += closed;
        without += open;
      }
      const Cylinder cylinder(gap, choices);
      const auto [closed, open] = leaks(cylinder, gap, count, choices);
      with += closed;
      without += open;
    }
    EXPECT_EQ(with, 0u) << "gap " << gap;
    // What says nothing tests nothing.
    EXPECT_GT(without, gap > 1e-8 ? count / 20 : 0) << "gap " << gap;
    std::cout << "gap " << gap << ": " << with << " leaks of some " << 9 * count << " rays, "
              << without << " without widths\n";
  }
}

}  // namespace
}  // namespace tessera
