// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_border_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {
namespace {

float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

Vec3d row_of(const SubPatch& border, int r) {
  return {border.frame[r][0], border.frame[r][1], border.frame[r][2]};
}
Vec3d centre_of(const SubPatch& border) {
  return {border.centre[0], border.centre[1], border.centre[2]};
}

// The curves y = c (x^2 - 1/2) + e (x^4 - x^2) of a frame, for |x| up to some.
struct Bend {
  double c, e;

  double y_of(double x) const { return c * (x * x - 0.5) + e * (x * x * (x * x - 1)); }
  double steepest(double x) const {
    return 2 * std::fabs(c) * x + std::fabs(e) * (4 * x * x * x + 2 * x);
  }
  // Between two places the curve is within |y''| h^2 / 8 of its chord, for a length h by x.
  double away_from_chord(double x, double h) const {
    const double second = 2 * std::fabs(c) + std::fabs(e) * std::max(2.0, 12 * x * x - 2);
    return second * h * h / 8;
  }
};

// How far in y what is nearer than `radius` to lines between places is from the curve at most.
double away_from(const Bend& bend, const SubPatch& border, std::span<const Vec3d> places,
                 double radius, double x_most) {
  const Vec3d row_x = row_of(border, 0), row_y = row_of(border, 1), centre = centre_of(border);
  double away = 0, longest = 0, x_before = dot(row_x, places[0] - centre);
  for (const Vec3d& place : places) {
    const double x = dot(row_x, place - centre), y = dot(row_y, place - centre);
    away = std::max(away, std::fabs(y - bend.y_of(x)));
    longest = std::max(longest, std::fabs(x - x_before));
    x_before = x;
  }
  away += bend.away_from_chord(x_most, longest);
  away += radius * (length(row_y) + bend.steepest(x_most) * length(row_x));
  return away * (1 + 0x1p-40);  // for the roundings of these lines
}

// The parabola's bend is that between the run's beginning and its middle; the quartic on top of it
// comes nearest to the places by least squares. Bounds are found for whatever both are.
void set_bend(std::span<const Vec3d> places, SubPatch& border) {
  const Vec3d row_x = row_of(border, 0), row_y = row_of(border, 1), centre = centre_of(border);
  const auto y_at = [&](std::size_t i) { return dot(row_y, places[i] - centre); };
  const std::size_t half = places.size() / 2;
  border.second[2][1] = static_cast<float>(y_at(0) - y_at(half));
  const Bend parabola{double{border.second[2][1]}, 0};
  double off = 0, weight = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double x = dot(row_x, places[i] - centre), w = x * x * (x * x - 1);
    off += w * (y_at(i) - parabola.y_of(x));
    weight += w * w;
  }
  border.second[0][1] = weight > 0 ? static_cast<float>(off / weight) : 0;
}

}  // namespace

RunPlaces::RunPlaces(const Patch& patch, FatBorders::Range run) {
  const TrimSet& trims = *patch.trims;
  PatchPoint points[kPatchPointsMax];
  take_points(patch, points);
  const int steps = run.end - run.first == 1 ? kStepsAlone : kStepsInRun;
  of_step_ = 1.0 / (steps * steps);
  for (std::uint32_t number = run.first; number < run.end; ++number) {
    const FatSpan& span = trims.borders()[number];
    widest_ = std::max(widest_, span.width);
    furthest_ = std::max(furthest_, span.away);
    for (int step = 0; step <= steps; ++step) {
      const double t = span.from() + step * ((span.to() - span.from()) / steps);
      const TrimPlace at = point_at(trims.cells().coefficients.data() + span.first,
                                    static_cast<int>(span.degree), {1 - t, t});
      const PatchJet jet = evaluate(patch, points, at.u, at.v);
      const Vec3d place{jet.point[0], jet.point[1], jet.point[2]};
      for (int a = 0; a < 3; ++a) most_ = std::max(most_, std::fabs(place[a]));
      places_[count_++] = place;
    }
  }
}

double RunPlaces::radius(const FatGrowth& growth) const {
  // Points of the patch in the world are rounded by 4 u of the coordinates.
  constexpr double kOff = 8 * 0x1p-24;
  return growth.of(widest_) + of_step_ * growth.of(furthest_) + kOff * most_;
}

// The frame is about all that is nearer than `radius` to the lines between the places, and thinnest
// across. With its numbers as they are stored, |row (P - centre)| is at most that of some place and
// `radius` times the row's length.
void set_frame(const RunPlaces& run, double radius, SubPatch& border) {
  const std::span<const Vec3d> places = run.places();
  const Vec3d chord = places.back() - places[0];
  const double length_of_chord = length(chord);
  const Vec3d along = length_of_chord > radius ? (1 / length_of_chord) * chord : Vec3d{1, 0, 0};
  Vec3d beside = places[places.size() / 2] - places[0];
  beside = beside - dot(beside, along) * along;
  if (!(length(beside) > 0x1p-20 * (length_of_chord + radius)))
    beside = cross(along, std::fabs(along.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
  const Vec3d b = (1 / length(beside)) * beside, n = cross(along, b);
  const Vec3d axes[3] = {along, b, n};
  Vec3d middle = places[0], rows[3];
  for (int r = 0; r < 3; ++r) {
    double low = 0, high = 0;
    for (const Vec3d& place : places) {
      low = std::min(low, dot(axes[r], place - places[0]));
      high = std::max(high, dot(axes[r], place - places[0]));
    }
    middle = middle + 0.5 * (low + high) * axes[r];
    rows[r] = (r < 2 ? 1 / (0.5 * (high - low) + radius) : 1) * axes[r];
  }
  for (int k = 0; k < 3; ++k) border.centre[k] = static_cast<float>(middle[k]);
  border.has_frame = true;
  for (int r = 0; r < 3; ++r) {
    border.reach[r] = 0;
    for (int k = 0; k < 3; ++k) {
      border.frame[r][k] = static_cast<float>(rows[r][k]);
      border.has_frame = border.has_frame && std::isfinite(border.frame[r][k]);
    }
  }
  set_bend(places, border);
  border.second[2][2] = border.second[0][2] = 0;
  widen(reach_in(border, run, radius), border);
}

FatReach reach_in(const SubPatch& border, const RunPlaces& run, double radius) {
  FatReach reach{};
  for (int r = 0; r < 3; ++r) {
    const Vec3d row = row_of(border, r);
    double most = 0;
    for (const Vec3d& place : run.places())
      most = std::max(most, std::fabs(dot(row, place - centre_of(border))));
    most += radius * length(row);
    // The square holds 1 of it. 2^-40 is for the roundings of these lines.
    reach.of_row[r] = std::max(0.0, most * (1 + 0x1p-40) - (r < 2 ? 1 : 0));
  }
  const double x_most = 1 + reach.of_row[0];
  const double c = border.second[2][1], e = border.second[0][1];
  reach.from_parabola = away_from({c, 0}, border, run.places(), radius, x_most);
  reach.from_quartic = away_from({c, e}, border, run.places(), radius, x_most);
  return reach;
}

void widen(const FatReach& reach, SubPatch& border) {
  for (int r = 0; r < 3; ++r) {
    border.reach[r] = std::max(border.reach[r], rounded_up(reach.of_row[r]));
    border.has_frame = border.has_frame && std::isfinite(border.reach[r]);
  }
  border.second[2][2] = std::max(border.second[2][2], rounded_up(reach.from_parabola));
  border.second[0][2] = std::max(border.second[0][2], rounded_up(reach.from_quartic));
}

Bounds3f box_of(const RunPlaces& run, double radius) {
  const float wide = rounded_up(radius + 2 * 0x1p-24 * (run.most() + radius));
  Bounds3f box;
  for (const Vec3d& place : run.places()) {
    // The place itself is rounded to float32, and so is the sum.
    box.grow(rounded(place) - Vec3f{wide, wide, wide});
    box.grow(rounded(place) + Vec3f{wide, wide, wide});
  }
  return box;
}

}  // namespace tessera::core
