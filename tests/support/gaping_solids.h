// SPDX-License-Identifier: Apache-2.0
// Solids of trimmed patches whose faces gape: their surfaces, and places of their edges.
//
// Threads. Owned by one test.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/math/vec3d.h"
#include "common/scene/patch_surface.h"
#include "tests/support/choices.h"
#include "tests/support/closed_solid.h"
#include "tests/support/trim_shapes.h"

namespace tessera::test {

// Patch after patch, each with its loops and their widths.
class SolidWriter {
 public:
  SolidWriter() { surface_.materials = {0}; }

  // A plane through `corner`, from there along u and v.
  void add_plane(Vec3d corner, Vec3d along_u, Vec3d along_v) {
    surface_.patches.push_back({1, 1, 0, 1});
    for (const Vec3d& p : {corner, corner + along_v, corner + along_u, corner + along_u + along_v})
      add_point(rounded(p));
    surface_.loop_counts.push_back(0);
  }
  // A quarter of a cylinder about z, u along the angle.
  void add_quarter(int number, double radius, double low, double high) {
    surface_.patches.push_back({2, 1, 1, 1});
    for (int i = 0; i < 3; ++i) {
      const double angle = (number + 0.5 * i) * std::numbers::pi / 2;
      const double weight = i == 1 ? std::sqrt(0.5) : 1, away = radius / weight;
      for (const double z : {low, high}) {
        add_point(rounded(Vec3d{away * std::cos(angle), away * std::sin(angle), z}));
        surface_.numbers.push_back(static_cast<float>(weight));
      }
    }
    surface_.loop_counts.push_back(0);
  }

  // What the loops enclose is kept, or left out.
  void keep_inside() { surface_.patches.back().keeps_outside = 0; }
  void add_rectangle(double u0, double v0, double u1, double v1, const double (&widths)[4]) {
    const auto f = [](double x) { return static_cast<float>(x); };
    test::add_rectangle(surface_, f(u0), f(v0), f(u1), f(v1));
    for (const double width : widths) surface_.trim_widths.push_back(f(width));
  }
  void add_circle(double u, double v, double radius, double width) {
    test::add_circle(surface_, static_cast<float>(u), static_cast<float>(v),
                     static_cast<float>(radius));
    surface_.trim_widths.resize(surface_.degrees.size(), static_cast<float>(width));
  }
  // Along a side of the square and back: it trims nothing.
  void add_side(TrimPoint from, TrimPoint to, double width) {
    test::add_loop(surface_, {from, to}, {1, 1});
    surface_.trim_widths.push_back(static_cast<float>(width));
    surface_.trim_widths.push_back(0);
  }

  const PatchSurface& surface() const { return surface_; }

 private:
  void add_point(Vec3f p) { surface_.numbers.insert(surface_.numbers.end(), {p.x, p.y, p.z}); }

  PatchSurface surface_;
};

// A cylinder about z of radius 1, from 0 to 2, of four quarters, which meet smoothly but for steps,
// and two planes; `gap` is the most that its faces are apart.
class Cylinder {
 public:
  Cylinder(double gap, Choices& choices) {
    const auto off = [&] { return 0.25 * gap * double{choices.sign()}; };
    for (double& x : radius_) x = 1 + off();
    for (double& x : ends_) x = off();
    for (int k = 0; k < 4; ++k) {
      low_[k] = off();
      high_[k] = 2 + off();
      writer_.add_quarter(k, radius_[k], low_[k], high_[k]);
      writer_.add_side({0, 0}, {0, 1}, gap);
      writer_.add_side({1, 0}, {1, 1}, gap);
      writer_.add_side({0, 0}, {1, 0}, gap);
      writer_.add_side({0, 1}, {1, 1}, gap);
    }
    for (int e = 0; e < 2; ++e) {
      Vec3d u{3, 0, 0}, v{0, 3, 0};
      if (e == 0) std::swap(u, v);
      writer_.add_plane({-1.5, -1.5, 2 * e + ends_[e]}, u, v);
      writer_.keep_inside();
      writer_.add_circle(0.5, 0.5, radius_[4 + e] / 3, gap);
    }
  }

  const PatchSurface& surface() const { return writer_.surface(); }

  EdgePlace place(Choices& choices) const {
    const unsigned k = choices.below(4), next = (k + 1) % 4;
    const double share = double{choices.share()};
    EdgePlace place;
    if (choices.one_in(2)) {
      const double angle = next * std::numbers::pi / 2;
      place.normal[0] = place.normal[1] = out(angle);
      place.on[0] = at(radius_[k], angle, low_[k] + share * (high_[k] - low_[k]));
      place.on[1] = at(radius_[next], angle, low_[next] + share * (high_[next] - low_[next]));
      return place;
    }
    const unsigned e = choices.below(2);
    const double angle = (k + share) * std::numbers::pi / 2;
    place.normal[0] = out(angle);
    place.normal[1] = {0, 0, e == 0 ? -1.0 : 1.0};
    place.on[0] = at(radius_[k], angle, e == 0 ? low_[k] : high_[k]);
    place.on[1] = at(radius_[4 + e], angle, 2 * e + ends_[e]);
    return place;
  }

 private:
  static Vec3d out(double angle) { return {std::cos(angle), std::sin(angle), 0}; }
  static Vec3d at(double radius, double angle, double z) {
    return {radius * std::cos(angle), radius * std::sin(angle), z};
  }

  SolidWriter writer_;
  double radius_[6], low_[4], high_[4], ends_[2];
};

}  // namespace tessera::test
