// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_border.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/vec3d.h"
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

// A span as one ray sees it.
class Passage {
 public:
  Passage(const Patch& patch, const SubPatch& part, const FatSpan& span,
          const TrimCoefficient* coefficients, const float* origin, const float* direction,
          float t_min)
      : patch_(patch),
        span_(span),
        coefficients_(coefficients),
        origin_{origin[0], origin[1], origin[2]},
        direction_{direction[0], direction[1], direction[2]},
        square_(dot(direction_, direction_)),
        t_min_(t_min),
        width_(part.reach[1]),
        ends_{across(end_of(part, 0)), across(end_of(part, 1))} {}

  // Whether the chord is near enough for the span to be met.
  bool may_meet(const SubPatch& part) const {
    return nearest(ends_[0], ends_[1]).distance <= width_ + double{part.reach[0]};
  }

  PatchAnswer search(double away) {
    take_points(patch_, points_);
    Piece stack[kStackMax];
    int count = 0;
    stack[count++] = {span_.from, span_.to, across(point_at_parameter(span_.from)),
                      across(point_at_parameter(span_.to)), away};
    while (count > 0) {
      const Piece piece = stack[--count];
      const Nearest at = nearest(piece.a, piece.b);
      if (!(at.distance - piece.away <= limit_())) continue;
      if (evaluations_ >= kFatEvaluationsMax) break;
      if (piece.away <= kNear * width_) {
        meet(piece.from + at.share * (piece.to - piece.from));
        continue;
      }
      const double middle = 0.5 * (piece.from + piece.to);
      const Vec3d there = across(point_at_parameter(middle));
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
  struct Piece {
    double from, to;
    Vec3d a, b;  // its ends, seen along the ray
    double away;
  };
  struct Nearest {
    double distance, share;
  };

  static Vec3d end_of(const SubPatch& part, int end) {
    return {part.frame[end][0], part.frame[end][1], part.frame[end][2]};
  }

  // Of a point, what is across the ray, which is the origin there.
  Vec3d across(Vec3d p) const {
    const Vec3d from = p - origin_;
    return from - (dot(from, direction_) / square_) * direction_;
  }

  static Nearest nearest(Vec3d a, Vec3d b) {
    const Vec3d along = b - a;
    const double size = dot(along, along);
    const double share = size > 0 ? std::clamp(-dot(a, along) / size, 0.0, 1.0) : 0;
    return {length(a + share * along), share};
  }

  double limit_() const { return std::min(width_, best_ - kNear * width_); }

  Vec3d point_at_parameter(double t) {
    place_ = point_at(coefficients_, static_cast<int>(span_.degree), {1 - t, t});
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
  const FatSpan& span_;
  const TrimCoefficient* const coefficients_;
  const Vec3d origin_, direction_;
  const double square_;
  const float t_min_;
  const double width_;
  const Vec3d ends_[2];
  PatchPoint points_[kPatchPointsMax];
  TrimPlace place_;
  int evaluations_ = 0;
  double best_ = kInf;
  PatchAnswer answer_{};
};

}  // namespace

// A rounding moves what was one point of two faces by 4 u of the coordinates, in each of them, by
// component: sqrt(3) 2 (4 u) < 2^-20.
FatPlacement::FatPlacement(const Transform& to_world)
    : stretch_(to_world.is_identity() ? 1 : stretch_of(to_world)),
      rounding_(to_world.is_identity() ? 0 : 0x1p-20) {}

SubPatch FatPlacement::placed(const Patch& patch, std::uint32_t span, Bounds3f& box) const {
  const TrimSet& trims = *patch.trims;
  const FatSpan& of = trims.borders()[span];
  SubPatch part{};
  part.level_u = kFatBorderLevel;
  part.column = static_cast<std::uint16_t>(span & 0xffffu);
  part.row = static_cast<std::uint16_t>(span >> 16);
  box = {};
  double most = 0;
  for (int end = 0; end < 2; ++end) {
    const double t = end == 0 ? of.from : of.to;
    const TrimPlace at = point_at(trims.cells().coefficients.data() + of.first,
                                  static_cast<int>(of.degree), {1 - t, t});
    const Vec3f p = rounded(point_of(evaluate(patch, at.u, at.v)));
    box.grow(p);
    for (int a = 0; a < 3; ++a) {
      part.frame[end][a] = p[a];
      most = std::max(most, std::fabs(double{p[a]}));
    }
  }
  // Ends are rounded by u / 2 by component, points of the patch in the world by 4 u.
  constexpr double kOff = 8 * 0x1p-24;
  part.reach[1] = rounded_up(double{of.width} * stretch_ + rounding_ * most);
  part.reach[0] = rounded_up(double{of.away} * stretch_ + kOff * most);
  // Twice: what is added is rounded as well.
  const float wide = rounded_up(double{part.reach[0]} + double{part.reach[1]} + kOff * most);
  box.lower = box.lower - Vec3f{wide, wide, wide};
  box.upper = box.upper + Vec3f{wide, wide, wide};
  return part;
}

PatchAnswer fat_border_answer(const Patch& patch, const SubPatch& part, const float* origin,
                              const float* direction, float t_min) {
  const std::uint32_t number = part.column | std::uint32_t{part.row} << 16;
  const TrimSet& trims = *patch.trims;
  const FatSpan& span = trims.borders()[number];
  Passage passage(patch, part, span, trims.cells().coefficients.data() + span.first, origin,
                  direction, t_min);
  if (!passage.may_meet(part)) return {};
  return passage.search(double{part.reach[0]});
}

}  // namespace tessera::core
