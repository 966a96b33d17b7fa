// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_border.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/fat_border_frame.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNear = 1.0 / 64;  // of the width: as near as the nearest point is found
constexpr int kStackMax = kFatEvaluationsMax + 2;

float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

Vec3d point_of(const PatchJet& jet) { return {jet.point[0], jet.point[1], jet.point[2]}; }

// The largest singular value of a map, by squaring M^T M: within 3^(1 / 2048) above it.
double stretch_of(const Transform& map) {
  double a[3][3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      a[i][j] = 0;
      for (std::size_t k = 0; k < 3; ++k) a[i][j] += double{map.m[k][i]} * double{map.m[k][j]};
    }
  double log = 0, power = 1;  // M^T M to this power is e^log a
  for (int step = 0; step < 10; ++step) {
    const double trace = a[0][0] + a[1][1] + a[2][2];
    if (!(trace > 0)) return 0;
    double square[3][3] = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) square[i][j] += a[i][k] / trace * (a[k][j] / trace);
    std::copy(&square[0][0], &square[0][0] + 9, &a[0][0]);
    log = 2 * (log + std::log(trace));
    power *= 2;
  }
  return std::exp((log + std::log(a[0][0] + a[1][1] + a[2][2])) / (2 * power));
}

// Whether the ray passes the plane n = 0 of the frame so far from the curves there that it meets
// nothing: what it would meet is within reach_n of the plane, so within |p| reach_n of where the
// ray passes it, by x, and so by y. Roundings are those of patch_decision-inl.h; those of the
// curves have 2^-48 of their terms.
bool passes_by(const SubPatch& part, double extent, const float* origin, const float* direction) {
  double from[3], o[3], d[3], norm[3], far = 0;
  for (int k = 0; k < 3; ++k) {
    from[k] = double{origin[k]} - double{part.centre[k]};
    far = std::max(far, std::fabs(from[k]));
  }
  for (int r = 0; r < 3; ++r) {
    const double f[3] = {part.frame[r][0], part.frame[r][1], part.frame[r][2]};
    o[r] = f[0] * from[0] + f[1] * from[1] + f[2] * from[2];
    d[r] = f[0] * double{direction[0]} + f[1] * double{direction[1]} + f[2] * double{direction[2]};
    norm[r] = std::fabs(f[0]) + std::fabs(f[1]) + std::fabs(f[2]);
  }
  const double inverse = 1 / d[2], p = d[0] * inverse, q = d[1] * inverse;
  const double x = o[0] - p * o[2], y = o[1] - q * o[2], square = x * x;
  const double noise = 0x1p-43 * (far + 2 * extent);
  const double away_x =
      std::fabs(p) * double{part.reach[2]} + (norm[0] + std::fabs(p) * norm[2]) * noise;
  const double away_y =
      std::fabs(q) * double{part.reach[2]} + (norm[1] + std::fabs(q) * norm[2]) * noise;
  const double c = part.second[2][1], e = part.second[0][1];
  const double x_most = std::max(std::fabs(x), 1 + double{part.reach[0]});
  const double of_c = std::fabs(c) * x_most, of_e = std::fabs(e) * x_most,
               x_square = x_most * x_most;
  const double roundings = 0x1p-48 * (std::fabs(y) + (of_c + of_e * x_square + of_e) * x_most);
  const double from_parabola = y - c * (square - 0.5);
  if (std::fabs(from_parabola) > double{part.second[2][2]} + away_y + 2 * of_c * away_x + roundings)
    return true;
  const double steepest = 2 * of_c + of_e * (4 * x_square + 2);
  return std::fabs(from_parabola - e * (square * (square - 1))) >
         double{part.second[0][2]} + away_y + steepest * away_x + roundings;
}

// The spans of a run as one ray sees them.
class Passage {
 public:
  Passage(const Patch& patch, const FatGrowth& growth, const float* origin, const float* direction,
          float t_min)
      : patch_(patch),
        growth_(growth),
        origin_{origin[0], origin[1], origin[2]},
        direction_{direction[0], direction[1], direction[2]},
        square_(dot(direction_, direction_)),
        t_min_(t_min) {
    take_points(patch, points_);
  }

  // coefficients: of the segment of the span.
  FatHit search(const FatSpan& span, const TrimCoefficient* coefficients) {
    take(span, coefficients);
    Piece stack[kStackMax];  // plain numbers, which cost nothing where most rays pass by at once
    int count = 0;
    stack[count++] = {span.from(), span.to(), across(point_at_parameter(span.from())),
                      across(point_at_parameter(span.to())), growth_.of(span.away)};
    while (count > 0) {
      const Piece piece = stack[--count];
      const Nearest at = nearest(piece.a.vector(), piece.b.vector());
      if (!(at.distance - piece.away <= limit_())) continue;
      if (evaluations_ >= kFatEvaluationsMax) break;
      if (piece.away <= kNear * width_) {
        meet(piece.from + at.share * (piece.to - piece.from));
        continue;
      }
      const double middle = 0.5 * (piece.from + piece.to);
      const Across there = across(point_at_parameter(middle));
      const Piece halves[2] = {{piece.from, middle, piece.a, there, 0.25 * piece.away},
                               {middle, piece.to, there, piece.b, 0.25 * piece.away}};
      // The nearer one is looked at first.
      const bool is_first = at.share < 0.5;
      stack[count++] = halves[is_first ? 1 : 0];
      stack[count++] = halves[is_first ? 0 : 1];
    }
    return answer_;
  }

 private:
  struct Across {
    double x, y, z;
    Vec3d vector() const { return {x, y, z}; }
  };
  struct Piece {
    double from, to;
    Across a, b;  // its ends, seen along the ray
    double away;
  };
  struct Nearest {
    double distance, share;
  };

  void take(const FatSpan& span, const TrimCoefficient* coefficients) {
    coefficients_ = coefficients;
    degree_ = static_cast<int>(span.degree);
    width_ = growth_.of(span.width);
    evaluations_ = 0;
    best_ = kInf;
    answer_ = {};
  }

  // Of a point, what is across the ray, which is the origin there.
  Across across(Vec3d p) const {
    const Vec3d from = p - origin_;
    const Vec3d beside = from - (dot(from, direction_) / square_) * direction_;
    return {beside.x, beside.y, beside.z};
  }

  static Nearest nearest(Vec3d a, Vec3d b) {
    const Vec3d along = b - a;
    const double size = dot(along, along);
    const double share = size > 0 ? std::clamp(-dot(a, along) / size, 0.0, 1.0) : 0;
    return {length(a + share * along), share};
  }

  double limit_() const { return std::min(width_, best_ - kNear * width_); }

  Vec3d point_at_parameter(double t) {
    place_ = point_at(coefficients_, degree_, {1 - t, t});
    ++evaluations_;
    return point_of(evaluate(patch_, points_, place_.u, place_.v));
  }

  void meet(double parameter) {
    const Vec3d from = point_at_parameter(parameter) - origin_;
    const double along = dot(from, direction_) / square_;
    const Vec3d beside = from - along * direction_;
    const double distance = length(beside);
    if (!(distance <= width_ && distance < best_)) return;
    const double half = std::sqrt((width_ - distance) * (width_ + distance) / square_);
    const auto t = static_cast<float>(along + half);
    if (!(along - half >= 0 && t >= t_min_)) return;
    best_ = distance;
    answer_ = {true, t, place_.u, place_.v};
  }

  const Patch& patch_;
  const FatGrowth growth_;
  const Vec3d origin_, direction_;
  const double square_;
  const float t_min_;
  PatchPoint points_[kPatchPointsMax];
  // The span at hand.
  const TrimCoefficient* coefficients_ = nullptr;
  int degree_ = 1;
  double width_ = 0;
  TrimPlace place_{};
  int evaluations_ = 0;
  double best_ = kInf;
  FatHit answer_{};
};

}  // namespace

// A rounding moves what was one point of two faces by 4 u of the coordinates, in each of them, by
// component: sqrt(3) 2 (4 u) < 2^-20.
FatPlacement::FatPlacement(const Transform& to_world)
    : stretch_(to_world.is_identity() ? 1 : rounded_up(stretch_of(to_world))),
      rounding_(to_world.is_identity() ? 0 : 0x1p-20) {}

SubPatch FatPlacement::placed(const Patch& patch, FatBorders::Range run, Bounds3f& box) const {
  const RunPlaces places(patch, run);
  SubPatch part{};
  part.second[0][0] = std::numeric_limits<float>::infinity();
  part.second[1][0] = static_cast<float>(run.first & 0xffffu);
  part.second[1][1] = static_cast<float>(run.first >> 16);
  part.column = static_cast<std::uint16_t>(run.end - run.first - 1);
  part.second[1][2] = stretch_;
  part.second[2][0] = rounding_ > 0 ? rounded_up(rounding_ * places.most()) : 0;
  const double radius = places.radius(growth_of(part));
  set_frame(places, radius, part);
  box.grow(box_of(places, radius));
  return part;
}

FatHit fat_border_hit(const Patch& patch, const SubPatch& part, const float* origin,
                      const float* direction, float t_min) {
  if (passes_by(part, patch.extent, origin, direction)) return {};
  const FatBorders::Range run = run_of(part);
  const TrimSet& trims = *patch.trims;
  Passage passage(patch, growth_of(part), origin, direction, t_min);
  FatHit best{};
  for (std::uint32_t number = run.first; number < run.end; ++number) {
    const FatSpan& span = trims.borders()[number];
    const FatHit hit = passage.search(span, trims.cells().coefficients.data() + span.first);
    if (hit.is_hit && (!best.is_hit || hit.t < best.t)) best = hit;
  }
  return best;
}

}  // namespace tessera::core
