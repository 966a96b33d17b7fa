// SPDX-License-Identifier: Apache-2.0
#include "tests/support/patch_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/core/primitive/patch/patch_evaluation.h"

namespace tessera::test {
namespace {

using Long = long double;
constexpr Long kInf = std::numeric_limits<Long>::infinity();
constexpr Long kU = 0x1p-24L;

Long dot(const Long* a, const Long* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
void cross(const Long* a, const Long* b, Long* to) {
  for (int k = 0; k < 3; ++k)
    to[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
void normalize(Long* a) {
  const Long size = std::sqrt(dot(a, a));
  for (int k = 0; k < 3; ++k) a[k] /= size;
}

// De Casteljau's scheme for one row of points: the value, and the slope from the last two.
struct Curve {
  Long value[4] = {}, slope[4] = {};

  Curve(Long (&p)[core::kPatchDegreeMax + 1][4], int degree, Long x) {
    for (int k = degree; k > 1; --k)
      for (int i = 0; i < k; ++i)
        for (int a = 0; a < 4; ++a) p[i][a] = (1 - x) * p[i][a] + x * p[i + 1][a];
    for (int a = 0; a < 4; ++a) {
      value[a] = (1 - x) * p[0][a] + x * p[1][a];
      slope[a] = degree * (p[1][a] - p[0][a]);
    }
  }
};

}  // namespace

LongJet long_jet(const core::Patch& patch, long double u, long double v) {
  Long rows[core::kPatchDegreeMax + 1][4] = {}, slopes[core::kPatchDegreeMax + 1][4] = {};
  for (int i = 0; i <= patch.degree_u; ++i) {
    Long row[core::kPatchDegreeMax + 1][4] = {};
    for (int j = 0; j <= patch.degree_v; ++j) {
      const core::PatchPoint p = core::plain::point_of(patch, (patch.degree_v + 1) * i + j);
      std::copy_n(p.x, 4, row[j]);
    }
    const Curve curve(row, patch.degree_v, v);
    std::copy_n(curve.value, 4, rows[i]);
    std::copy_n(curve.slope, 4, slopes[i]);
  }
  const Curve by_u(rows, patch.degree_u, u), by_v(slopes, patch.degree_u, u);
  LongJet jet{};
  const Long w = by_u.value[3];
  for (int a = 0; a < 3; ++a) {
    jet.point[a] = by_u.value[a] / w;
    jet.du[a] = (by_u.slope[a] - jet.point[a] * by_u.slope[3]) / w;
    jet.dv[a] = (by_v.value[a] - jet.point[a] * by_v.value[3]) / w;
  }
  return jet;
}

void PatchReference::solve(const core::Patch& patch, const core::PatchRay& ray,
                           std::vector<PatchRoot>& roots) {
  patch_ = patch;
  m_ = patch.degree_u;
  n_ = patch.degree_v;
  int small = 0;
  for (int k = 0; k < 3; ++k) {
    o_[k] = ray.origin[k];
    d_[k] = ray.direction[k];
    if (std::fabs(d_[k]) < std::fabs(d_[small])) small = k;
  }
  Long axis[3] = {};
  axis[small] = 1;
  cross(axis, d_, n1_);
  normalize(n1_);
  cross(d_, n1_, n2_);
  normalize(n2_);
  Net net{};
  Long high_w = 0;
  far_ = 0;
  for (int k = 0; k < (m_ + 1) * (n_ + 1); ++k) {
    const core::PatchPoint p = core::plain::point_of(patch, k);
    const Long w = p.x[3];
    Long x[3] = {};
    for (int a = 0; a < 3; ++a) {
      x[a] = p.x[a] - o_[a] * w;
      far_ = std::max(far_, std::fabs(x[a]) / w);
    }
    net.f[0][k] = dot(n1_, x);
    net.f[1][k] = dot(n2_, x);
    high_w = std::max(high_w, w);
  }
  tolerance_ = 16 * kU * far_;
  noise_ = 0x1p-53L * far_ * high_w;
  // Beyond the border by more than the tolerance, where the surface is not stretched badly.
  constexpr Long kBeyond = 0x1p-14L;
  for (Long* f : {net.f[0], net.f[1]})
    for (const bool by_u : {false, true}) {
      cut(f, by_u, 1 + kBeyond, false);
      cut(f, by_u, -kBeyond / (1 + kBeyond), true);
    }
  roots_ = &roots;
  first_ = roots.size();
  halve(net, {-kBeyond, 1 + kBeyond, -kBeyond, 1 + kBeyond}, 0);
}

void PatchReference::cut(Long* f, bool by_u, Long a, bool keeps_high) const {
  const int degree = by_u ? m_ : n_, others = by_u ? n_ : m_;
  const int along = by_u ? n_ + 1 : 1, across = by_u ? 1 : n_ + 1;
  for (int other = 0; other <= others; ++other) {
    Long* row = f + across * other;
    for (int k = 1; k <= degree; ++k) {
      if (keeps_high) {
        for (int i = 0; i <= degree - k; ++i)
          row[along * i] = (1 - a) * row[along * i] + a * row[along * (i + 1)];
      } else {
        for (int i = degree; i >= k; --i)
          row[along * i] = (1 - a) * row[along * (i - 1)] + a * row[along * i];
      }
    }
  }
}

PatchReference::Span PatchReference::slope(const Long* f, bool by_u) const {
  Span s{kInf, -kInf};
  const int step = by_u ? n_ + 1 : 1, di = by_u ? 1 : 0, dj = by_u ? 0 : 1;
  for (int i = 0; i + di <= m_; ++i)
    for (int j = 0; j + dj <= n_; ++j) {
      const Long* at = f + (n_ + 1) * i + j;
      s.low = std::min(s.low, at[step] - at[0]);
      s.high = std::max(s.high, at[step] - at[0]);
    }
  const Long half = Long(by_u ? m_ : n_) / 2;
  return {half * s.low, half * s.high};
}

void PatchReference::halve(const Net& net, const Place& place, int depth) {
  const int count = (m_ + 1) * (n_ + 1);
  Long spread = 0;
  for (const Long* f : {net.f[0], net.f[1]}) {
    const auto [low, high] = std::minmax_element(f, f + count);
    if (*low > noise_ || *high < -noise_) return;
    spread = std::max(spread, *high - *low);
  }
  const Span fx = slope(net.f[0], true), fy = slope(net.f[0], false);
  const Span gx = slope(net.f[1], true), gy = slope(net.f[1], false);
  const auto middle = [](Span s) { return (s.low + s.high) / 2; };
  const auto radius = [](Span s) { return (s.high - s.low) / 2; };
  const auto size = [](Span s) { return std::max(s.high, -s.low); };
  const Long a = middle(fx), b = middle(fy), c = middle(gx), d = middle(gy);
  const Long unit = std::fabs(1 / (a * d - b * c));
  const Long rf = radius(fx) + radius(fy), rg = radius(gx) + radius(gy);
  const Long r = std::max((std::fabs(d) * rf + std::fabs(b) * rg) * unit,
                          (std::fabs(c) * rf + std::fabs(a) * rg) * unit);
  if (r <= 0.125L || spread <= 8 * noise_ || depth > 120) {
    polish(place, !(r <= 0.125L));
    return;
  }
  if (roots_->size() > first_ + 4000) return;  // the ray lies in the surface
  const bool by_u = std::max(size(fx), size(gx)) >= std::max(size(fy), size(gy));
  for (const bool is_high : {false, true}) {
    Net half;
    for (int k = 0; k < 2; ++k) {
      std::copy(net.f[k], net.f[k] + count, half.f[k]);
      cut(half.f[k], by_u, 0.5L, is_high);
    }
    Place part = place;
    const Long mid = by_u ? (place.u0 + place.u1) / 2 : (place.v0 + place.v1) / 2;
    (by_u ? (is_high ? part.u0 : part.u1) : (is_high ? part.v0 : part.v1)) = mid;
    halve(half, part, depth + 1);
  }
}

void PatchReference::polish(const Place& place, bool is_cluster) {
  Long u = (place.u0 + place.u1) / 2, v = (place.v0 + place.v1) / 2, t = 0;
  bool is_found = is_cluster;
  for (int step = 0; step < 40; ++step) {
    const LongJet jet = long_jet(patch_, u, v);
    Long s[3] = {};
    for (int k = 0; k < 3; ++k) s[k] = jet.point[k] - o_[k];
    t = dot(s, d_) / dot(d_, d_);
    if (is_cluster) break;
    const Long f = dot(s, n1_), g = dot(s, n2_);
    const Long fx = dot(jet.du, n1_), fy = dot(jet.dv, n1_);
    const Long gx = dot(jet.du, n2_), gy = dot(jet.dv, n2_);
    const Long unit = 1 / (fx * gy - fy * gx);
    const Long du = (fy * g - gy * f) * unit, dv = (gx * f - fx * g) * unit;
    u += du;
    v += dv;
    // Without a root in its box the iteration goes anywhere, and its steps stay large. Points are
    // good to 2^-57 of what they are made of, which may be far from the origin of the world.
    Long largest = far_;
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(o_[k]) + far_);
    const Long rounding = 0x1p-57L * largest * std::fabs(unit);
    is_found = std::fabs(du) <= 1e-15L + rounding * (std::fabs(gy) + std::fabs(fy)) &&
               std::fabs(dv) <= 1e-15L + rounding * (std::fabs(gx) + std::fabs(fx));
    if (std::fabs(du) <= 1e-17L && std::fabs(dv) <= 1e-17L) break;
  }
  if (!is_found) return;
  const Long wide_u = 1e-12L + (place.u1 - place.u0) * 1e-6L,
             wide_v = 1e-12L + (place.v1 - place.v0) * 1e-6L;
  if (!is_cluster && !(u >= place.u0 - wide_u && u <= place.u1 + wide_u && v >= place.v0 - wide_v &&
                       v <= place.v1 + wide_v))
    return;
  for (std::size_t k = first_; k < roots_->size(); ++k)
    if (std::fabs((*roots_)[k].u - u) < 1e-11L && std::fabs((*roots_)[k].v - v) < 1e-11L) return;
  report(u, v, t, is_cluster);
}

void PatchReference::report(Long u, Long v, Long t, bool is_cluster) {
  PatchRoot root;
  root.t = static_cast<double>(t);
  root.u = static_cast<double>(u);
  root.v = static_cast<double>(v);
  const LongJet jet = long_jet(patch_, u, v);
  const Long fx = dot(n1_, jet.du), fy = dot(n1_, jet.dv);
  const Long gx = dot(n2_, jet.du), gy = dot(n2_, jet.dv);
  const Long unit = std::fabs(1 / (fx * gy - fy * gx));
  const Long to_u = (std::fabs(gy) + std::fabs(fy)) * unit;
  const Long to_v = (std::fabs(gx) + std::fabs(fx)) * unit;
  // The distance across the ray from the border: that of the parameter, over what a shift of the
  // ray moves the parameter by.
  const Long margin = std::min(std::min(u, 1 - u) / to_u, std::min(v, 1 - v) / to_v);
  if (!is_cluster && margin < -2 * tolerance_) return;
  root.by_shift[0] = static_cast<double>(to_u);
  root.by_shift[1] = static_cast<double>(to_v);
  root.is_edge = !(margin > tolerance_);
  root.is_fragile = is_cluster || is_fragile(u, v, std::max(to_u, to_v));
  Long n[3] = {};
  cross(jet.du, jet.dv, n);
  const Long length = std::sqrt(dot(d_, d_));
  const Long cosine = std::fabs(dot(n, d_)) / (std::sqrt(dot(n, n)) * length);
  root.allowed_t = static_cast<double>(8 * kU * far_ / (length * cosine) + 2 * kU * std::fabs(t));
  roots_->push_back(root);
}

// Second derivatives by differences.
bool PatchReference::is_fragile(Long u, Long v, Long inverse) const {
  constexpr Long kStep = 0x1p-12L;
  Long bend = 0;
  for (const bool by_u : {false, true}) {
    const LongJet a = long_jet(patch_, u - (by_u ? kStep : 0), v - (by_u ? 0 : kStep));
    const LongJet b = long_jet(patch_, u + (by_u ? kStep : 0), v + (by_u ? 0 : kStep));
    Long most = 0;
    for (int k = 0; k < 3; ++k)
      most = std::max(most, (std::fabs(b.du[k] - a.du[k]) + std::fabs(b.dv[k] - a.dv[k])));
    bend += most / (2 * kStep);
  }
  return !(inverse * inverse * tolerance_ * bend < 0.25L);
}

}  // namespace tessera::test
