// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_border_spans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/patch_net.h"
#include "slave/core/primitive/patch/sub_patch_bounds.h"
#include "slave/core/primitive/patch/trim_part.h"

namespace tessera::core {
namespace {

constexpr int kTileBits = 3;  // 8 x 8 tiles
constexpr int kTiles = 1 << kTileBits;
constexpr double kUncertain = 5 * 0x1p-24;  // of the square: 4.5 u, and room for roundings
constexpr int kSpanDepthMax = 8;            // halvings of a segment
constexpr double kStraight = 1.0 / 4;       // of its chord: a span that is so near to it is short
constexpr double kShare = 1.0 / 4;          // of the patch: spans are no longer, for their boxes

// Bounds of the sizes of derivatives, by component.
struct Derivatives {
  double u[3] = {}, v[3] = {}, uu[3] = {}, uv[3] = {}, vv[3] = {};

  void grow(const Derivatives& d) {
    for (int a = 0; a < 3; ++a) {
      u[a] = std::max(u[a], d.u[a]);
      v[a] = std::max(v[a], d.v[a]);
      uu[a] = std::max(uu[a], d.uu[a]);
      uv[a] = std::max(uv[a], d.uv[a]);
      vv[a] = std::max(vv[a], d.vv[a]);
    }
  }
};

// Bounds of a patch's derivatives over its tiles, made when they are asked for.
class TileBounds {
 public:
  explicit TileBounds(const Patch& patch) : patch_(patch), tiles_(kTiles * kTiles) {
    take_points(patch, points_);
    const PatchJet middle = evaluate(patch, points_, 0.5, 0.5);
    for (PatchNet* net : {&x_[0], &x_[1], &x_[2], &w_})
      *net = net_of(patch.degree_u, patch.degree_v);
    double from[3];
    for (int a = 0; a < 3; ++a) from[a] = static_cast<float>(middle.point[a]);
    for (int i = 0; i <= w_.m; ++i)
      for (int j = 0; j <= w_.n; ++j) {
        const PatchPoint& p = points_[(w_.n + 1) * i + j];
        w_.c[i][j] = p.x[3];
        // In units of the patch's extent, so that bounds do not depend on it.
        for (int a = 0; a < 3; ++a) x_[a].c[i][j] = (p.x[a] - from[a] * p.x[3]) / patch.extent;
      }
  }

  Derivatives over(double u_low, double u_high, double v_low, double v_high) {
    Derivatives all;
    for (int i = tile_of(u_low); i <= tile_of(u_high); ++i)
      for (int j = tile_of(v_low); j <= tile_of(v_high); ++j) {
        std::unique_ptr<Derivatives>& tile = tiles_[static_cast<std::size_t>(kTiles * i + j)];
        if (!tile) tile = std::make_unique<Derivatives>(of_tile(i, j));
        all.grow(*tile);
      }
    return all;
  }

 private:
  static int tile_of(double x) {
    return static_cast<int>(std::clamp(std::floor(x * kTiles), 0.0, kTiles - 1.0));
  }

  Derivatives of_tile(int column, int row) const {
    PatchNet x[3] = {x_[0], x_[1], x_[2]}, w = w_;
    for (PatchNet* net : {&x[0], &x[1], &x[2], &w})
      for (int bit = kTileBits - 1; bit >= 0; --bit) {
        cut_u(*net, 0.5, (column >> bit & 1) != 0);
        cut_v(*net, 0.5, (row >> bit & 1) != 0);
      }
    double error[3];
    for (int a = 0; a < 3; ++a) error[a] = kNetError * size_of(x_[a]);
    const SubPatchBounds bounds = bounds_of(x, w, patch_.is_rational, error);
    constexpr double kHalf = 0.5 / kTiles;  // a side of a tile is two units of its bounds
    const PatchJet jet = evaluate(patch_, points_, (2 * column + 1) * kHalf, (2 * row + 1) * kHalf);
    Derivatives d;
    for (int a = 0; a < 3; ++a) {
      d.uu[a] = bounds.xx[a] * patch_.extent / (kHalf * kHalf);
      d.uv[a] = bounds.xy[a] * patch_.extent / (kHalf * kHalf);
      d.vv[a] = bounds.yy[a] * patch_.extent / (kHalf * kHalf);
      d.u[a] = std::fabs(jet.du[a]) + kHalf * (d.uu[a] + d.uv[a]);
      d.v[a] = std::fabs(jet.dv[a]) + kHalf * (d.uv[a] + d.vv[a]);
    }
    return d;
  }

  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  PatchNet x_[3], w_;
  std::vector<std::unique_ptr<Derivatives>> tiles_;
};

// Where a coordinate of a part of a curve lies, and bounds of its derivatives by the part's own
// parameter, in which it has length 1.
struct Course {
  double low, high, speed, bend;

  Course(const TrimPart& part, int degree, double TrimCoefficient::*coordinate) {
    double x[kTrimDegreeMax + 1];
    for (int i = 0; i <= degree; ++i) x[i] = part.net[i].*coordinate / part.net[i].w;
    low = *std::min_element(x, x + degree + 1);
    high = *std::max_element(x, x + degree + 1);
    const double middle = 0.5 * (low + high), reach = 0.5 * (high - low);
    double w_least = std::numeric_limits<double>::infinity();
    double a[kTrimDegreeMax + 1];
    for (int i = 0; i <= degree; ++i) {
      w_least = std::min(w_least, part.net[i].w);
      a[i] = part.net[i].w * (x[i] - middle);
    }
    double a1 = 0, a2 = 0, w1 = 0, w2 = 0;
    const auto w = [&](int i) { return part.net[i].w; };
    for (int i = 0; i < degree; ++i) {
      a1 = std::max(a1, std::fabs(a[i + 1] - a[i]));
      w1 = std::max(w1, std::fabs(w(i + 1) - w(i)));
    }
    for (int i = 0; i + 1 < degree; ++i) {
      a2 = std::max(a2, std::fabs((a[i + 2] - a[i + 1]) - (a[i + 1] - a[i])));
      w2 = std::max(w2, std::fabs((w(i + 2) - w(i + 1)) - (w(i + 1) - w(i))));
    }
    const double n = degree;
    // Each has some 2^7 roundings of 2^-53.
    constexpr double kRoom = 1 + 0x1p-40;
    speed = n * (a1 + w1 * reach) / w_least * kRoom;
    bend = (n * (n - 1) * (a2 + w2 * reach) + 2 * n * w1 * speed) / w_least * kRoom;
  }
};

double away_from_chord(const Course& u, const Course& v, const Derivatives& d) {
  double second[3];
  for (int a = 0; a < 3; ++a)
    second[a] = d.uu[a] * u.speed * u.speed + 2 * d.uv[a] * u.speed * v.speed +
                d.vv[a] * v.speed * v.speed + d.u[a] * u.bend + d.v[a] * v.bend;
  return length(Vec3d{second[0], second[1], second[2]}) / 8;
}

class SegmentSplitter {
 public:
  SegmentSplitter(const Patch& patch, std::vector<FatSpan>& to)
      : patch_(patch), bounds_(patch), to_(to) {
    take_points(patch, points_);
  }

  void split(const FatSegment& segment, const TrimCoefficient* coefficients) {
    const int degree = static_cast<int>(segment.degree);
    TrimPart whole;
    int choices = 1;
    for (int i = 0; i <= degree; ++i) {
      const TrimCoefficient& c = coefficients[i];
      whole.net[i] = {c.u / choices, c.v / choices, c.w / choices};
      choices = choices * (degree - i) / (i + 1);
    }
    std::vector<TrimPart> parts{whole};
    while (!parts.empty()) {
      TrimPart& part = parts.back();
      if (add(part, segment, coefficients)) {
        parts.pop_back();
      } else {
        const TrimPart half = first_half(part, degree);
        parts.push_back(half);
      }
    }
  }

 private:
  PatchJet jet_at(const TrimCoefficient* coefficients, int degree, TrimParameter at) const {
    const TrimPlace place = point_at(coefficients, degree, at);
    return evaluate(patch_, points_, place.u, place.v);
  }

  // Returns: whether the part is a span already.
  bool add(const TrimPart& part, const FatSegment& segment, const TrimCoefficient* coefficients) {
    const int degree = static_cast<int>(segment.degree);
    const Course u(part, degree, &TrimCoefficient::u), v(part, degree, &TrimCoefficient::v);
    const bool is_last = part.depth >= kSpanDepthMax;
    double size_u = 0, size_v = 0;
    Vec3d ends[3];
    const TrimParameter at[3] = {part.from, middle(part.from, part.to), part.to};
    for (int k = 0; k < 3; ++k) {
      const PatchJet jet = jet_at(coefficients, degree, at[k]);
      ends[k] = {jet.point[0], jet.point[1], jet.point[2]};
      size_u = std::max(size_u, length(Vec3d{jet.du[0], jet.du[1], jet.du[2]}));
      size_v = std::max(size_v, length(Vec3d{jet.dv[0], jet.dv[1], jet.dv[2]}));
    }
    const double width = double{segment.width} + kUncertain * (size_u + size_v);
    const double away = away_from_chord(u, v, bounds_.over(u.low, u.high, v.low, v.high));
    const double chord = length(ends[2] - ends[0]);
    if (!is_last &&
        (chord > kShare * patch_.extent || !(away <= std::max(width, kStraight * chord))))
      return false;
    const auto up = [](double x) {
      return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
    };
    // Nothing is known of a span with bounds beyond float32: it is left out.
    if (!std::isfinite(up(away)) || !std::isfinite(up(width))) return true;
    to_.push_back({part.from.t, part.to.t, up(width), up(away), segment.first, segment.degree});
    return true;
  }

  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  TileBounds bounds_;
  std::vector<FatSpan>& to_;
};

}  // namespace

FatBorders::FatBorders(const PatchSurface& surface, std::span<const FatSegment> segments,
                       const std::vector<TrimCoefficient>& coefficients) {
  if (segments.empty()) return;
  std::size_t next = 0;
  for (PatchCursor at(surface); at.is_any(); at.advance()) {
    first_.push_back(static_cast<std::uint32_t>(spans_.size()));
    if (next == segments.size() || segments[next].patch != at.patch()) continue;
    const std::size_t first = next;
    while (next < segments.size() && segments[next].patch == at.patch()) ++next;
    const PatchForm& form = at.form();
    const auto numbers = std::span(surface.numbers).subspan(at.first_number(), form.number_count());
    const auto checked =
        checked_patch({form.degree_u, form.degree_v, form.is_rational != 0, numbers});
    if (!checked.is_ok()) continue;
    const auto splitter = std::make_unique<SegmentSplitter>(checked->patch(), spans_);
    for (const FatSegment& segment : segments.subspan(first, next - first))
      splitter->split(segment, coefficients.data() + segment.first);
  }
  first_.push_back(static_cast<std::uint32_t>(spans_.size()));
  spans_.shrink_to_fit();
}

}  // namespace tessera::core
