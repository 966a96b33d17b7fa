// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/sah_split.h"

#include <algorithm>
#include <array>

namespace tessera::core {
namespace {

struct Judge {
  const Bounds3f& voxel;
  const KdBuildConfig& config;
  double area_inverse;
  SahSplit best;

  // Weighs the plane with the counts of both sides; keeps it if it is the cheapest so far.
  void weigh(int axis, float plane, std::size_t below, std::size_t above) {
    if (!(plane > voxel.lower[axis] && plane < voxel.upper[axis])) return;
    const Vec3f e = voxel.extent();
    const double a = e[(axis + 1) % 3], b = e[(axis + 2) % 3];
    const double side = a * b, rim = a + b;
    const double area_below = side + rim * (double{plane} - voxel.lower[axis]);
    const double area_above = side + rim * (double{voxel.upper[axis]} - plane);
    double cost =
        config.cost_intersect * area_inverse *
        (area_below * static_cast<double>(below) + area_above * static_cast<double>(above));
    cost += config.cost_traverse;
    if (below == 0 || above == 0) cost *= 1.0 - config.empty_bonus;
    if (cost < best.cost) best = {axis, plane, static_cast<float>(cost)};
  }
};

// Weighs every face of a box from `from` to `to`, if there are at most `faces_max` of them.
template <class Boxes>
void sweep_axis(const Boxes& boxes, int axis, float from, float to, std::size_t faces_max,
                SahScratch& s, Judge& judge) {
  s.lowers.clear();
  s.uppers.clear();
  s.flats.clear();
  const std::size_t n = boxes.size();
  // Numbers of boxes that have begun and ended below the plane. A box that begins in the plane has
  // not begun; one that ends in it has ended.
  std::size_t begun = 0, ended = 0;
  const auto is_here = [&](float face) { return face >= from && face <= to; };
  for (std::size_t i = 0; i < n; ++i) {
    const float lower = boxes[i].lower[axis], upper = boxes[i].upper[axis];
    if (is_here(lower)) s.lowers.push_back(lower);
    if (is_here(upper)) s.uppers.push_back(upper);
    if (lower == upper && is_here(lower)) s.flats.push_back(lower);
    begun += lower < from ? 1u : 0u;
    ended += upper < from ? 1u : 0u;
  }
  if (s.lowers.size() + s.uppers.size() > faces_max) return;
  std::sort(s.lowers.begin(), s.lowers.end());
  std::sort(s.uppers.begin(), s.uppers.end());
  std::sort(s.flats.begin(), s.flats.end());
  std::size_t l = 0, u = 0, f = 0;
  while (l < s.lowers.size() || u < s.uppers.size()) {
    const bool is_lower =
        u == s.uppers.size() || (l < s.lowers.size() && s.lowers[l] < s.uppers[u]);
    const float plane = is_lower ? s.lowers[l] : s.uppers[u];
    for (; u < s.uppers.size() && s.uppers[u] <= plane; ++u) ++ended;
    while (f < s.flats.size() && s.flats[f] < plane) ++f;
    std::size_t flats_here = 0;
    while (f + flats_here < s.flats.size() && s.flats[f + flats_here] == plane) ++flats_here;
    judge.weigh(axis, plane, begun + flats_here, n - ended);
    for (; l < s.lowers.size() && s.lowers[l] <= plane; ++l) ++begun;
  }
}

template <class Boxes>
void bin_axis(const Boxes& boxes, int axis, float lower, float upper, Judge& judge) {
  const std::size_t n = boxes.size();
  judge.weigh(axis, lower, 0, n);
  judge.weigh(axis, upper, n, 0);
  const float width = upper - lower;
  if (!(width > 0)) return;
  const auto bins = static_cast<std::size_t>(judge.config.bin_count);
  std::array<std::size_t, kKdBinsMax> begins, ends;
  std::fill_n(begins.begin(), bins, 0);
  std::fill_n(ends.begin(), bins, 0);
  const float scale = static_cast<float>(bins) / width;
  const auto bin_of = [&](float x) {
    const float b = std::clamp((x - lower) * scale, 0.0f, static_cast<float>(bins - 1));
    return static_cast<std::size_t>(b);
  };
  for (std::size_t i = 0; i < n; ++i) {
    ++begins[bin_of(boxes[i].lower[axis])];
    ++ends[bin_of(boxes[i].upper[axis])];
  }
  std::size_t below = 0, above = n;
  for (std::size_t b = 1; b < bins; ++b) {
    below += begins[b - 1];
    above -= ends[b - 1];
    const float plane = lower + width * (static_cast<float>(b) / static_cast<float>(bins));
    judge.weigh(axis, plane, below, above);
  }
}

}  // namespace

// Planes in the bins beside a border cost less than the border by this factor at most, nearly
// always.
constexpr float kRefinable = 1.05f;

template <class Boxes>
SahSplit choose_split(const Boxes& boxes, const Bounds3f& voxel, const KdBuildConfig& config,
                      SahScratch& scratch) {
  const Vec3f e = voxel.extent();
  const double half_area = double{e.x} * e.y + double{e.y} * e.z + double{e.z} * e.x;
  const float leaf_cost = config.cost_intersect * static_cast<float>(boxes.size());
  // A voxel of no area (all geometry on a line or point) is a leaf; so is one whose area overflows.
  if (boxes.size() == 0 || !(half_area > 0) || !(1 / half_area > 0)) return {-1, 0, leaf_cost};
  Judge judge{voxel, config, 1 / half_area, {-1, 0, leaf_cost}};
  if (boxes.size() <= config.sweep_max) {
    constexpr float kInf = Bounds3f::kInf;
    for (int axis = 0; axis < 3; ++axis)
      sweep_axis(boxes, axis, -kInf, kInf, 2 * boxes.size(), scratch, judge);
    return judge.best;
  }
  Bounds3f tight;
  for (std::size_t i = 0; i < boxes.size(); ++i) tight.grow(boxes[i]);
  tight.lower = max(tight.lower, voxel.lower);
  tight.upper = min(tight.upper, voxel.upper);
  SahSplit of_axis[3];
  for (int axis = 0; axis < 3; ++axis) {
    Judge own = judge;
    own.best = {-1, 0, Bounds3f::kInf};
    bin_axis(boxes, axis, tight.lower[axis], tight.upper[axis], own);
    of_axis[axis] = own.best;
    if (own.best.cost < judge.best.cost) judge.best = own.best;
  }
  if (boxes.size() < config.refine_min) return judge.best;
  const auto faces_max =
      static_cast<std::size_t>(config.refine_share * static_cast<float>(2 * boxes.size()));
  const float enough = kRefinable * judge.best.cost;
  for (int axis = 0; axis < 3; ++axis) {
    if (of_axis[axis].axis != axis || of_axis[axis].cost > enough) continue;
    const float plane = of_axis[axis].plane;
    const float width =
        (tight.upper[axis] - tight.lower[axis]) / static_cast<float>(config.bin_count);
    sweep_axis(boxes, axis, plane - width, plane + width, faces_max, scratch, judge);
  }
  return judge.best;
}

template SahSplit choose_split(const WholeBoxes&, const Bounds3f&, const KdBuildConfig&,
                               SahScratch&);
template SahSplit choose_split(const PartBoxes&, const Bounds3f&, const KdBuildConfig&,
                               SahScratch&);

}  // namespace tessera::core
