// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/curve2.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::import::cad {
namespace {

constexpr int kDepthMax = 40;     // of halvings: a parameter to 1e-12
constexpr int kBorderDepth = 12;  // a curve that is on a border over 1/4096 of it does not cross it
constexpr std::size_t kRootsMax = 64;
constexpr double kNoise = 1e-13;  // of coordinates: some roundings of differences
constexpr int kFitDepthMax = 12;  // 4,096 curves for one

// The numbers of Bernstein's form of w(t) (x(t) - value).
std::vector<double> offsets_of(const Curve2& curve, bool is_v, double value) {
  std::vector<double> offsets;
  for (const Control2& p : curve.points) offsets.push_back(p.weight * ((is_v ? p.v : p.u) - value));
  return offsets;
}

// Adds the roots of Bernstein's form in [from, to], by halving. What is nearer to 0 than `noise`
// all along is a curve on the border and has none.
void add_roots(const std::vector<double>& form, double noise, double from, double to, int depth,
               std::vector<double>& roots) {
  const auto [low, high] = std::minmax_element(form.begin(), form.end());
  if (*low > 0 || *high < 0 || roots.size() >= kRootsMax) return;
  if (depth < kBorderDepth && *low >= -noise && *high <= noise) return;
  if (depth == kDepthMax) {
    if (roots.empty() || from - roots.back() > 1e-12) roots.push_back((from + to) / 2);
    return;
  }
  std::vector<double> left(form.size()), right = form;
  for (std::size_t k = 0; k < form.size(); ++k) {
    left[k] = right[0];
    for (std::size_t i = 0; i + k + 1 < form.size(); ++i) right[i] = (right[i] + right[i + 1]) / 2;
  }
  // De Casteljau leaves the right part in `right`: its last number first.
  const double middle = (from + to) / 2;
  add_roots(left, noise, from, middle, depth + 1, roots);
  add_roots(right, noise, middle, to, depth + 1, roots);
}

// Solves the square system; Requires: it is regular, as that of distinct nodes is.
void solve(std::vector<std::vector<double>>& a, std::vector<Point2>& b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= f * a[k][j];
      b[i] = {b[i].u - f * b[k].u, b[i].v - f * b[k].v};
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j)
      b[k] = {b[k].u - a[k][j] * b[j].u, b[k].v - a[k][j] * b[j].v};
    b[k] = {b[k].u / a[k][k], b[k].v / a[k][k]};
  }
}

double bernstein(std::size_t n, std::size_t i, double t) {
  double value = 1;
  for (std::size_t k = 0; k < i; ++k)
    value *= t * static_cast<double>(n - k) / static_cast<double>(k + 1);
  return value * std::pow(1 - t, static_cast<double>(n - i));
}

Curve2 interpolated(const std::function<Point2(double)>& place, double from, double to,
                    std::size_t degree) {
  std::vector<std::vector<double>> a(degree + 1);
  std::vector<Point2> b;
  for (std::size_t i = 0; i <= degree; ++i) {
    const double t =
        (1 - std::cos(std::numbers::pi * static_cast<double>(i) / static_cast<double>(degree))) / 2;
    for (std::size_t j = 0; j <= degree; ++j) a[i].push_back(bernstein(degree, j, t));
    b.push_back(place(from + (to - from) * t));
  }
  const Point2 first = b.front(), last = b.back();
  solve(a, b);
  Curve2 curve;
  for (const Point2& p : b) curve.points.push_back({p.u, p.v, 1});
  curve.points.front() = {first.u, first.v, 1};
  curve.points.back() = {last.u, last.v, 1};
  return curve;
}

void add_fit(const std::function<Point2(double)>& place, double from, double to, double tolerance,
             int depth, std::vector<Curve2>& curves) {
  for (const std::size_t degree : {1u, 3u, 5u, 7u, 9u}) {
    Curve2 curve = interpolated(place, from, to, degree);
    double worst = 0;
    const int checks = 4 * static_cast<int>(degree) + 3;
    for (int i = 1; i < checks; ++i) {
      const double t = static_cast<double>(i) / checks;
      const Point2 is = curve.at(t), want = place(from + (to - from) * t);
      worst = std::max(worst, std::hypot(is.u - want.u, is.v - want.v));
    }
    if (worst <= tolerance || (degree == 9 && depth == kFitDepthMax)) {
      curves.push_back(std::move(curve));
      return;
    }
  }
  const double middle = (from + to) / 2;
  add_fit(place, from, middle, tolerance, depth + 1, curves);
  add_fit(place, middle, to, tolerance, depth + 1, curves);
}

}  // namespace

Point2 Curve2::at(double t) const {
  if (t <= 0) return first();
  if (t >= 1) return last();
  double u = 0, v = 0, w = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double share = bernstein(degree(), i, t) * points[i].weight;
    u += share * points[i].u;
    v += share * points[i].v;
    w += share;
  }
  return {u / w, v / w};
}

std::pair<Curve2, Curve2> split(const Curve2& curve, double t) {
  Curve2 left, right = curve;
  left.edge = curve.edge;
  const std::size_t count = curve.points.size();
  std::vector<Control2>& p = right.points;
  for (Control2& c : p) c = {c.u * c.weight, c.v * c.weight, c.weight};
  for (std::size_t k = 0; k < count; ++k) {
    left.points.push_back(p[0]);
    for (std::size_t i = 0; i + k + 1 < count; ++i) {
      p[i] = {p[i].u + t * (p[i + 1].u - p[i].u), p[i].v + t * (p[i + 1].v - p[i].v),
              p[i].weight + t * (p[i + 1].weight - p[i].weight)};
    }
  }
  for (Curve2* part : {&left, &right})
    for (Control2& c : part->points) c = {c.u / c.weight, c.v / c.weight, c.weight};
  left.points.front() = curve.points.front();
  right.points.back() = curve.points.back();
  right.points.front().u = left.points.back().u;
  right.points.front().v = left.points.back().v;
  return {left, right};
}

Curve2 reversed(Curve2 curve) {
  std::reverse(curve.points.begin(), curve.points.end());
  return curve;
}

Curve2 with_end_weights_1(Curve2 curve) {
  // t -> c t / (1 - t + c t) multiplies weight i by c^i; a common factor changes nothing.
  const double first = curve.points.front().weight, last = curve.points.back().weight;
  if (first == 1 && last == 1) return curve;
  const double n = static_cast<double>(curve.degree());
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    double& weight = curve.points[i].weight;
    weight = weight / first * std::pow(first / last, static_cast<double>(i) / n);
  }
  curve.points.front().weight = curve.points.back().weight = 1;
  return curve;
}

std::vector<double> crossings(const Curve2& curve, bool is_v, double value) {
  const std::vector<double> form = offsets_of(curve, is_v, value);
  if (std::ranges::all_of(form, [](double x) { return x == 0; })) return {};
  double size = std::fabs(value);
  for (const Control2& p : curve.points)
    size = std::max(size, p.weight * std::fabs(is_v ? p.v : p.u));
  std::vector<double> roots;
  add_roots(form, kNoise * size, 0, 1, 0, roots);
  std::erase_if(roots, [](double t) { return t < 1e-11 || t > 1 - 1e-11; });
  return roots;
}

std::vector<Curve2> fit(const std::function<Point2(double)>& place, double tolerance) {
  std::vector<Curve2> curves;
  add_fit(place, 0, 1, tolerance, 0, curves);
  return curves;
}

bool is_enclosed(const std::vector<Curve2>& curves, Point2 point) {
  bool is_odd = false;
  for (const Curve2& curve : curves) {
    // Which side the ends are on decides how many crossings count, so that no corner counts twice.
    const bool is_right = curve.first().u > point.u;
    std::vector<double> roots = crossings(curve, false, point.u);
    bool was_right = is_right;
    for (std::size_t i = 0; i < roots.size(); ++i) {
      const double next = i + 1 < roots.size() ? (roots[i] + roots[i + 1]) / 2 : 1;
      const bool now_right = curve.at(next).u > point.u;
      if (now_right != was_right && curve.at(roots[i]).v > point.v) is_odd = !is_odd;
      was_right = now_right;
    }
    if (roots.empty() && is_right != (curve.last().u > point.u) && curve.last().v > point.v)
      is_odd = !is_odd;
  }
  return is_odd;
}

}  // namespace tessera::import::cad
