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

// The frame has x along the chord, which is 2 long there, y and n across it. With its numbers as
// they are stored, all points within `reach` of the chord have |row (P - centre)| of no more than
// that at the chord's ends and `reach` times the row's length.
void frame_about(const Vec3d (&ends)[2], double reach, SubPatch& part) {
  const Vec3d chord = ends[1] - ends[0];
  const double half = 0.5 * length(chord);
  Vec3d along = half > reach ? (0.5 / half) * chord : Vec3d{1, 0, 0};
  const Vec3d other = std::fabs(along.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d up = cross(along, other);
  const Vec3d n = (1 / length(up)) * up, b = cross(n, along);
  const Vec3d rows[3] = {(1 / std::max(half, reach)) * along, (1 / reach) * b, n};
  const Vec3d middle = 0.5 * (ends[0] + ends[1]);
  for (int k = 0; k < 3; ++k) part.centre[k] = static_cast<float>(middle[k]);
  const Vec3d centre{part.centre[0], part.centre[1], part.centre[2]};
  part.has_frame = true;
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) part.frame[r][k] = static_cast<float>(rows[r][k]);
    const Vec3d row{part.frame[r][0], part.frame[r][1], part.frame[r][2]};
    double most = reach * length(row);
    for (const Vec3d& end : ends)
      most = std::max(most, reach * length(row) + std::fabs(dot(row, end - centre)));
    // The square holds 1 of it. 2^-40 is for the roundings of these lines.
    part.reach[r] = rounded_up(std::max(0.0, most * (1 + 0x1p-40) - (r < 2 ? 1 : 0)));
    part.has_frame = part.has_frame && std::isfinite(part.reach[r]) && std::isfinite(row.x) &&
                     std::isfinite(row.y) && std::isfinite(row.z);
  }
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
        width_(part.second[1][2]) {
    take_points(patch, points_);
  }

  FatHit search(double away) {
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
  PatchPoint points_[kPatchPointsMax];
  TrimPlace place_;
  int evaluations_ = 0;
  double best_ = kInf;
  FatHit answer_{};
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
  Vec3d ends[2];
  double most = 0;
  for (int end = 0; end < 2; ++end) {
    const double t = end == 0 ? of.from : of.to;
    const TrimPlace at = point_at(trims.cells().coefficients.data() + of.first,
                                  static_cast<int>(of.degree), {1 - t, t});
    ends[end] = point_of(evaluate(patch, at.u, at.v));
    for (int a = 0; a < 3; ++a) most = std::max(most, std::fabs(ends[end][a]));
  }
  SubPatch part{};
  for (float& second : part.second[0]) second = std::numeric_limits<float>::infinity();
  part.second[1][0] = static_cast<float>(span & 0xffffu);
  part.second[1][1] = static_cast<float>(span >> 16);
  part.second[1][2] = rounded_up(double{of.width} * stretch_ + rounding_ * most);
  // Points of the patch in the world are rounded by 4 u of the coordinates.
  constexpr double kOff = 8 * 0x1p-24;
  part.second[2][0] = rounded_up(double{of.away} * stretch_ + rounding_ * most);
  const double reach = double{part.second[1][2]} + double{part.second[2][0]} + kOff * most;
  frame_about(ends, reach, part);
  for (const Vec3d& end : ends) {
    const Vec3f wide{rounded_up(reach), rounded_up(reach), rounded_up(reach)};
    // The end itself is rounded to float32, and so is the sum.
    const Vec3f off = wide + Vec3f{1, 1, 1} * rounded_up(2 * 0x1p-24 * (most + reach));
    box.grow(rounded(end) - off);
    box.grow(rounded(end) + off);
  }
  return part;
}

FatHit fat_border_hit(const Patch& patch, const SubPatch& part, const float* origin,
                      const float* direction, float t_min) {
  const std::uint32_t number = static_cast<std::uint32_t>(part.second[1][0]) |
                               static_cast<std::uint32_t>(part.second[1][1]) << 16;
  const TrimSet& trims = *patch.trims;
  const FatSpan& span = trims.borders()[number];
  Passage passage(patch, part, span, trims.cells().coefficients.data() + span.first, origin,
                  direction, t_min);
  return passage.search(double{part.second[2][0]});
}

}  // namespace tessera::core
