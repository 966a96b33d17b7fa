// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_splitting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/core/primitive/patch/trim_part.h"

namespace tessera::core {
namespace {

// Bound of |u''| and |v''| over a part, by its own parameter, in which it has length 1. With A =
// w (C - middle): w C' = A' - w' (C - middle), w C'' = A'' - 2 w' C' - w'' (C - middle), and ranges
// of the derivatives' control points. Roundings are 2^-46 of what is bounded, for which a factor is
// left.
double bend_of(const TrimPart& part, int degree, std::span<const double> u,
               std::span<const double> v) {
  const auto [u_least, u_most] = std::minmax_element(u.begin(), u.end());
  const auto [v_least, v_most] = std::minmax_element(v.begin(), v.end());
  const double middle_u = 0.5 * (*u_least + *u_most), middle_v = 0.5 * (*v_least + *v_most);
  const double reach = 0.5 * std::max(*u_most - *u_least, *v_most - *v_least);
  TrimCoefficient c[kTrimDegreeMax + 1];
  double w_least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double w = part.net[i].w;
    c[i] = {w * (u[i] - middle_u), w * (v[i] - middle_v), w};
    w_least = std::min(w_least, w);
  }
  const double n = degree;
  double a1 = 0, w1 = 0, a2 = 0, w2 = 0;
  for (int i = 0; i < degree; ++i) {
    a1 = std::max({a1, std::fabs(c[i + 1].u - c[i].u), std::fabs(c[i + 1].v - c[i].v)});
    w1 = std::max(w1, std::fabs(c[i + 1].w - c[i].w));
  }
  for (int i = 0; i + 1 < degree; ++i) {
    const auto second = [](double a, double b, double d) { return std::fabs((d - b) - (b - a)); };
    a2 = std::max(
        {a2, second(c[i].u, c[i + 1].u, c[i + 2].u), second(c[i].v, c[i + 1].v, c[i + 2].v)});
    w2 = std::max(w2, second(c[i].w, c[i + 1].w, c[i + 2].w));
  }
  const double speed = n * (a1 + w1 * reach) / w_least;
  return (n * (n - 1) * (a2 + w2 * reach) + 2 * n * w1 * speed) / w_least * (1 + 0x1p-30);
}

// How one coordinate goes along a curve.
class Trend {
 public:
  // Takes more values, in order. Returns: whether they still go one way; if not, nothing is taken.
  bool takes(std::span<const double> values) {
    Trend with = *this;
    for (const double x : values) with.take(x);
    if (with.turn_up_ > 2 * kTrimTurn && with.turn_down_ > 2 * kTrimTurn) return false;
    *this = with;
    return true;
  }

  // Whether these values alone go one way, or nowhere.
  static bool is_one(std::span<const double> values) {
    Trend alone;
    for (const double x : values) alone.take(x);
    return std::min(alone.turn_up_, alone.turn_down_) <= kTrimTurn;
  }

 private:
  void take(double x) {
    most_ = std::max(most_, x);
    least_ = std::min(least_, x);
    turn_down_ = std::max(turn_down_, most_ - x);
    turn_up_ = std::max(turn_up_, x - least_);
  }

  // The values so far, and how far they went up and down at most.
  double most_ = -std::numeric_limits<double>::infinity();
  double least_ = std::numeric_limits<double>::infinity();
  double turn_up_ = 0, turn_down_ = 0;
};

class Splitter {
 public:
  Splitter(int degree, std::uint32_t first, std::vector<TrimPiece>& to)
      : degree_(degree), first_(first), to_(to) {}

  void run(std::span<const TrimPoint> points) {
    TrimPart whole;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double w = points[i].weight;
      whole.net[i] = {w * double{points[i].u}, w * double{points[i].v}, w};
    }
    std::vector<TrimPart> parts{whole};
    while (!parts.empty()) {
      TrimPart& part = parts.back();
      project(part);
      if (part.depth < kTrimDepthMax && !(Trend::is_one(u_) && Trend::is_one(v_))) {
        const TrimPart half = first_half(part, degree_);
        parts.push_back(half);
        continue;
      }
      add(part);
      parts.pop_back();
    }
    close();
  }

 private:
  // The control points of a part, as u_ and v_.
  void project(const TrimPart& part) {
    u_.clear();
    v_.clear();
    for (int i = 0; i <= degree_; ++i) {
      u_.push_back(part.net[i].u / part.net[i].w);
      v_.push_back(part.net[i].v / part.net[i].w);
    }
  }

  // Joins a part to the piece at hand if both go the same way, else begins another piece.
  void add(const TrimPart& part) {
    Trend u = trend_u_, v = trend_v_;
    if (!(u.takes(u_) && v.takes(v_)) && !hull_.empty()) {
      close();
      u = v = Trend();
      u.takes(u_);
      v.takes(v_);
    }
    trend_u_ = u;
    trend_v_ = v;
    if (hull_.empty()) from_ = part.from;
    to_at_ = part.to;
    bend_ = std::max(bend_, std::ldexp(bend_of(part, degree_, u_, v_), 2 * part.depth));
    for (std::size_t i = 0; i < u_.size(); ++i) hull_.push_back({u_[i], v_[i]});
  }

  void close() {
    TrimPiece piece{};
    const TrimPlace ends[2] = {hull_.front(), hull_.back()};
    const TrimParameter at[2] = {from_, to_at_};
    const bool is_upside_down = static_cast<float>(ends[1].v) < static_cast<float>(ends[0].v);
    for (int e = 0; e < 2; ++e) {
      const int of = is_upside_down ? 1 - e : e;
      piece.u[e] = static_cast<float>(ends[of].u);
      piece.v[e] = static_cast<float>(ends[of].v);
      piece.at[e] = encoded(at[of]);
    }
    piece.first = first_ & (kTrimCoefficientsMax - 1);
    piece.degree = static_cast<std::uint32_t>(degree_) & 15u;
    piece.falls = piece.u[1] < piece.u[0] ? 1 : 0;
    bound(piece);
    hull_.clear();
    bend_ = 0;
    trend_u_ = trend_v_ = Trend();
    if (piece.u[0] != piece.u[1] || piece.v[0] != piece.v[1]) to_.push_back(piece);
  }

  // The band of all control points, rounded outwards. Errors of double move a point by 2^-50.
  void bound(TrimPiece& piece) const {
    const double u0 = piece.u[0], v0 = piece.v[0];
    const double du = piece.u[1] - u0, dv = piece.v[1] - v0;
    double low = 0, high = 0;
    for (const TrimPlace& p : hull_) {
      const double side = (p.u - u0) * dv - (p.v - v0) * du;
      low = std::min(low, side);
      high = std::max(high, side);
    }
    constexpr float kInf = std::numeric_limits<float>::infinity();
    piece.band_low = std::nextafter(static_cast<float>(low), -kInf);
    piece.band_high = std::nextafter(static_cast<float>(high), kInf);
    piece.bend = std::nextafter(static_cast<float>(bend_ / 8), kInf);
    if (degree_ > 1) return;
    // A straight line is its chord.
    piece.band_low = piece.band_high = 0;
  }

  const int degree_;
  const std::uint32_t first_;
  std::vector<TrimPiece>& to_;
  std::vector<double> u_, v_;  // of the part at hand
  // The piece at hand.
  std::vector<TrimPlace> hull_;
  TrimParameter from_, to_at_;
  double bend_ = 0;
  Trend trend_u_, trend_v_;
};

}  // namespace

void split_segment(std::span<const TrimPoint> points, std::uint32_t first,
                   std::vector<TrimPiece>& to) {
  Splitter(static_cast<int>(points.size()) - 1, first, to).run(points);
}

}  // namespace tessera::core
