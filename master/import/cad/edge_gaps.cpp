// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/edge_gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tessera::import::cad {
namespace {

constexpr int kSteps = 16;           // of a segment, where it is looked at
constexpr double kSamePlace = 1.01;  // distances within this factor are the same
constexpr double kRounding = 0x1p-24;
constexpr int kRefines = 30;  // golden sections: to a share of 1e-6 of a step

struct Place3 {
  double x, y, z;
};

double distance(const Place3& a, const Place3& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

// The places of the patches' points in `numbers`.
std::vector<std::size_t> first_numbers(const PatchSurface& surface) {
  std::vector<std::size_t> firsts;
  for (PatchCursor at(surface); at.is_any(); at.advance()) firsts.push_back(at.first_number());
  return firsts;
}

void fill_bernstein(int n, double t, double* values) {
  values[0] = 1;
  for (int k = 1; k <= n; ++k) {
    values[k] = t * values[k - 1];
    for (int i = k - 1; i > 0; --i) values[i] = t * values[i - 1] + (1 - t) * values[i];
    values[0] *= 1 - t;
  }
}

Place3 place_on(const PatchForm& form, const float* numbers, Point2 at) {
  double in_u[kPatchDegreesMax + 1], in_v[kPatchDegreesMax + 1];
  fill_bernstein(form.degree_u, at.u, in_u);
  fill_bernstein(form.degree_v, at.v, in_v);
  double x = 0, y = 0, z = 0, w = 0;
  for (int i = 0; i <= form.degree_u; ++i) {
    for (int j = 0; j <= form.degree_v; ++j) {
      const double share = in_u[i] * in_v[j] * (form.is_rational != 0 ? double{numbers[3]} : 1.0);
      x += share * double{numbers[0]};
      y += share * double{numbers[1]};
      z += share * double{numbers[2]};
      w += share;
      numbers += form.is_rational != 0 ? 4 : 3;
    }
  }
  return {x / w, y / w, z / w};
}

// The curve of a face along an edge, as places in space and as the curves that they are on.
class Side {
 public:
  Side(const PatchSurface& surface, const std::vector<std::size_t>& firsts,
       std::span<const EdgeUse> uses)
      : surface_(surface), firsts_(firsts), uses_(uses) {
    for (const EdgeUse& use : uses)
      for (int i = 0; i <= kSteps; ++i) places_.push_back(at(use, static_cast<double>(i) / kSteps));
  }

  double farthest_from(const Side& other) const {
    double worst = 0;
    for (const Place3& p : places_) worst = std::max(worst, other.nearest(p));
    return worst;
  }

  double largest() const {
    double most = 0;
    for (const Place3& p : places_)
      most = std::max({most, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    return most;
  }

 private:
  Place3 at(const EdgeUse& use, double t) const {
    return place_on(surface_.patches[use.patch], surface_.numbers.data() + firsts_[use.patch],
                    use.curve.at(t));
  }

  double nearest(const Place3& p) const {
    double best = std::numeric_limits<double>::infinity();
    for (const Place3& q : places_) best = std::min(best, distance(p, q));
    // Of curves that meet at the nearest place, each may come nearer between its places.
    const double looked_at = best * kSamePlace;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (distance(p, places_[i]) <= looked_at) best = std::min(best, nearest_about(p, i));
    return best;
  }

  // The least distance of the curve from `p` between the places before and behind number `i`.
  double nearest_about(const Place3& p, std::size_t i) const {
    const EdgeUse& use = uses_[i / (kSteps + 1)];
    const double middle = static_cast<double>(i % (kSteps + 1)) / kSteps;
    double low = std::max(0.0, middle - 1.0 / kSteps), high = std::min(1.0, middle + 1.0 / kSteps);
    double best = distance(p, places_[i]);
    constexpr double kGolden = 0.38196601125010515;
    for (int k = 0; k < kRefines; ++k) {
      const double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
      const double da = distance(p, at(use, a)), db = distance(p, at(use, b));
      best = std::min({best, da, db});
      (da < db ? high : low) = da < db ? b : a;
    }
    return best;
  }

  const PatchSurface& surface_;
  const std::vector<std::size_t>& firsts_;
  std::span<const EdgeUse> uses_;
  std::vector<Place3> places_;
};

}  // namespace

EdgeGaps measure_gaps(const PatchSurface& surface, std::vector<EdgeUse>& uses,
                      std::size_t edge_count) {
  EdgeGaps gaps;
  gaps.widths.resize(edge_count);
  const std::vector<std::size_t> firsts = first_numbers(surface);
  std::ranges::stable_sort(uses, [](const EdgeUse& a, const EdgeUse& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin;
    std::vector<Side> sides;
    while (end < uses.size() && uses[end].edge == uses[begin].edge) {
      const std::size_t from = end;
      while (end < uses.size() && uses[end].edge == uses[begin].edge &&
             uses[end].face == uses[from].face)
        ++end;
      sides.emplace_back(surface, firsts, std::span(uses).subspan(from, end - from));
    }
    if (sides.size() < 2) {
      ++gaps.open;
    } else {
      ++gaps.shared;
      double& width = gaps.widths[static_cast<std::size_t>(uses[begin].edge)];
      for (const Side& a : sides)
        for (const Side& b : sides)
          if (&a != &b) width = std::max(width, a.farthest_from(b));
      gaps.largest = std::max(gaps.largest, width);
      for (const Side& side : sides) width = std::max(width, kRounding * side.largest());
    }
    begin = end;
  }
  return gaps;
}

}  // namespace tessera::import::cad
