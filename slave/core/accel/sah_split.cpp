// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/sah_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

// Adds the faces from `from` to `to`.
template <class Boxes>
void collect(const Boxes& boxes, int axis, float from, float to, SahFaces& faces) {
  const auto is_here = [&](float face) { return face >= from && face <= to; };
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const float lower = boxes[i].lower[axis], upper = boxes[i].upper[axis];
    if (is_here(lower)) faces.lowers.push_back(lower);
    if (is_here(upper)) faces.uppers.push_back(upper);
    if (lower == upper && is_here(lower)) faces.flats.push_back(lower);
    faces.begun += lower < from ? 1u : 0u;
    faces.ended += upper < from ? 1u : 0u;
  }
}

void clear(SahFaces& faces) {
  faces.lowers.clear();
  faces.uppers.clear();
  faces.flats.clear();
  faces.begun = faces.ended = 0;
}

// Weighs every face of `count` boxes. A box that begins in the plane has not begun below it; one
// that ends in it has ended.
void sweep(const SahFaces& s, int axis, std::size_t count, Judge& judge) {
  std::size_t begun = s.begun, ended = s.ended;
  std::size_t l = 0, u = 0, f = 0;
  while (l < s.lowers.size() || u < s.uppers.size()) {
    const bool is_lower =
        u == s.uppers.size() || (l < s.lowers.size() && s.lowers[l] < s.uppers[u]);
    const float plane = is_lower ? s.lowers[l] : s.uppers[u];
    for (; u < s.uppers.size() && s.uppers[u] <= plane; ++u) ++ended;
    while (f < s.flats.size() && s.flats[f] < plane) ++f;
    std::size_t flats_here = 0;
    while (f + flats_here < s.flats.size() && s.flats[f + flats_here] == plane) ++flats_here;
    judge.weigh(axis, plane, begun + flats_here, count - ended);
    for (; l < s.lowers.size() && s.lowers[l] <= plane; ++l) ++begun;
  }
}

template <class Boxes>
void sweep_all(const Boxes& boxes, SahScratch& scratch, Judge& judge) {
  constexpr float kInf = Bounds3f::kInf;
  for (int axis = 0; axis < 3; ++axis) {
    SahFaces& faces = scratch.faces[axis];
    clear(faces);
    collect(boxes, axis, -kInf, kInf, faces);
    std::sort(faces.lowers.begin(), faces.lowers.end());
    std::sort(faces.uppers.begin(), faces.uppers.end());
    std::sort(faces.flats.begin(), faces.flats.end());
    sweep(faces, axis, boxes.size(), judge);
  }
}

// Bins of equal width across a box.
struct BinMap {
  Vec3f lower, width, scale;
  int count;

  BinMap(const Bounds3f& box, int bin_count)
      : lower(box.lower), width(box.extent()), count(bin_count) {
    const auto scale_of = [bin_count](float extent) {
      const float per_unit = static_cast<float>(bin_count) / extent;
      return extent > 0 && std::isfinite(per_unit) ? per_unit : 0;
    };
    scale = {scale_of(width.x), scale_of(width.y), scale_of(width.z)};
  }
  bool are_thick(int axis) const { return scale[axis] > 0; }
  std::size_t bin_of(float x, int axis) const {
    const float b = (x - lower[axis]) * scale[axis];  // NaN: a box reaches far out of the voxel
    return b > 0 ? static_cast<std::size_t>(std::min(b, static_cast<float>(count - 1))) : 0;
  }
  // The plane in front of a bin.
  float plane(std::size_t bin, int axis) const {
    return lower[axis] + width[axis] * (static_cast<float>(bin) / static_cast<float>(count));
  }
};

template <class Boxes>
void count_bins(const Boxes& boxes, const BinMap& map, KdBins (&bins)[3]) {
  for (KdBins& axis : bins) {
    std::fill_n(axis.begins.begin(), map.count, 0u);
    std::fill_n(axis.ends.begin(), map.count, 0u);
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Bounds3f& box = boxes[i];
    for (int axis = 0; axis < 3; ++axis) {
      ++bins[axis].begins[map.bin_of(box.lower[axis], axis)];
      ++bins[axis].ends[map.bin_of(box.upper[axis], axis)];
    }
  }
}

void add(const KdBins& part, int count, KdBins& bins) {
  for (std::size_t b = 0; b < static_cast<std::size_t>(count); ++b) {
    bins.begins[b] += part.begins[b];
    bins.ends[b] += part.ends[b];
  }
}

// Weighs the planes between bins, and both faces of what holds all boxes.
void weigh_bins(const KdBins& bins, const BinMap& map, int axis, float upper, std::size_t count,
                Judge& judge) {
  judge.weigh(axis, map.lower[axis], 0, count);
  judge.weigh(axis, upper, count, 0);
  if (!map.are_thick(axis)) return;
  std::size_t below = 0, above = count;
  for (std::size_t b = 1; b < static_cast<std::size_t>(map.count); ++b) {
    below += bins.begins[b - 1];
    above -= bins.ends[b - 1];
    judge.weigh(axis, map.plane(b, axis), below, above);
  }
}

// The boxes of a voxel, looked at in parts.
template <class Boxes>
class Survey {
 public:
  Survey(const Boxes& boxes, SahScratch& scratch, std::size_t parts, int thread_count)
      : boxes_(boxes), scratch_(scratch), parts_(parts), thread_count_(thread_count) {
    if (parts > 1) scratch.parts.resize(parts);
  }

  Bounds3f tight() {
    in_parts(boxes_, parts_, thread_count_, [this](std::size_t part, const Boxes& some) {
      Bounds3f box;
      for (std::size_t i = 0; i < some.size(); ++i) box.grow(some[i]);
      scratch_of(part).tight = box;
    });
    Bounds3f tight = scratch_of(0).tight;
    for (std::size_t part = 1; part < parts_; ++part) tight.grow(scratch_of(part).tight);
    return tight;
  }

  const KdBins (&bins(const BinMap& map))[3] {
    in_parts(boxes_, parts_, thread_count_, [&](std::size_t part, const Boxes& some) {
      count_bins(some, map, scratch_of(part).bins);
    });
    for (std::size_t part = 1; part < parts_; ++part) {
      for (int axis = 0; axis < 3; ++axis)
        add(scratch_of(part).bins[axis], map.count, scratch_of(0).bins[axis]);
    }
    return scratch_of(0).bins;
  }

  // Finds the faces on each axis between the two planes, sorted. Where they are more than faces_max
  // there are none. Planes of NaN: none are looked for.
  const SahFaces (&faces(const Vec3f& from, const Vec3f& to, std::size_t faces_max))[3] {
    in_parts(boxes_, parts_, thread_count_, [&](std::size_t part, const Boxes& some) {
      for (int axis = 0; axis < 3; ++axis) {
        SahFaces& faces = scratch_of(part).faces[axis];
        clear(faces);
        if (from[axis] <= to[axis]) collect(some, axis, from[axis], to[axis], faces);
      }
    });
    for (int axis = 0; axis < 3; ++axis) {
      std::size_t count = 0;
      for (std::size_t part = 0; part < parts_; ++part) {
        const SahFaces& faces = scratch_of(part).faces[axis];
        count += faces.lowers.size() + faces.uppers.size();
      }
      if (count <= faces_max) continue;
      for (std::size_t part = 0; part < parts_; ++part) clear(scratch_of(part).faces[axis]);
    }
    constexpr int kLists = 9;  // of three kinds on three axes
    if (parts_ == 1) {
      for (int list = 0; list < kLists; ++list) sort(list);
    } else {
      run_tasks(kLists, thread_count_, [this](int list) { sort(list); });
    }
    for (std::size_t part = 1; part < parts_; ++part) {
      for (int axis = 0; axis < 3; ++axis) {
        scratch_of(0).faces[axis].begun += scratch_of(part).faces[axis].begun;
        scratch_of(0).faces[axis].ended += scratch_of(part).faces[axis].ended;
      }
    }
    return scratch_of(0).faces;
  }

 private:
  SahScratch& scratch_of(std::size_t part) { return parts_ == 1 ? scratch_ : scratch_.parts[part]; }
  void sort(int list) {
    constexpr std::vector<float> SahFaces::*kKinds[] = {&SahFaces::lowers, &SahFaces::uppers,
                                                        &SahFaces::flats};
    const int axis = list / 3;
    const auto kind = kKinds[list % 3];
    std::vector<float>& all = scratch_of(0).faces[axis].*kind;
    for (std::size_t part = 1; part < parts_; ++part) {
      const std::vector<float>& some = scratch_of(part).faces[axis].*kind;
      all.insert(all.end(), some.begin(), some.end());
    }
    std::sort(all.begin(), all.end());
  }

  const Boxes boxes_;
  SahScratch& scratch_;
  const std::size_t parts_;
  const int thread_count_;
};

}  // namespace

// Planes in the bins beside a border cost less than the border by this factor at most, nearly
// always.
constexpr float kRefinable = 1.05f;

template <class Boxes>
SahSplit choose_split(const Boxes& boxes, const Bounds3f& voxel, const KdBuildConfig& config,
                      SahScratch& scratch, std::size_t parts, int thread_count) {
  const Vec3f e = voxel.extent();
  const double half_area = double{e.x} * e.y + double{e.y} * e.z + double{e.z} * e.x;
  const std::size_t count = boxes.size();
  const float leaf_cost = config.cost_intersect * static_cast<float>(count);
  // A voxel of no area (all geometry on a line or point) is a leaf; so is one whose area overflows.
  if (count == 0 || !(half_area > 0) || !(1 / half_area > 0)) return {-1, 0, leaf_cost};
  Judge judge{voxel, config, 1 / half_area, {-1, 0, leaf_cost}};
  if (count <= config.sweep_max) {
    sweep_all(boxes, scratch, judge);
    return judge.best;
  }
  Survey<Boxes> survey(boxes, scratch, parts, thread_count);
  Bounds3f tight = survey.tight();
  tight.lower = max(tight.lower, voxel.lower);
  tight.upper = min(tight.upper, voxel.upper);
  const BinMap map(tight, config.bin_count);
  const KdBins(&bins)[3] = survey.bins(map);
  SahSplit of_axis[3];
  for (int axis = 0; axis < 3; ++axis) {
    Judge own = judge;
    own.best = {-1, 0, Bounds3f::kInf};
    weigh_bins(bins[axis], map, axis, tight.upper[axis], count, own);
    of_axis[axis] = own.best;
    if (own.best.cost < judge.best.cost) judge.best = own.best;
  }
  if (count < config.refine_min) return judge.best;
  const auto faces_max =
      static_cast<std::size_t>(config.refine_share * static_cast<float>(2 * count));
  const float enough = kRefinable * judge.best.cost;
  float from[3], to[3];
  for (int axis = 0; axis < 3; ++axis) {
    const bool may_win = of_axis[axis].axis == axis && !(of_axis[axis].cost > enough);
    const float plane = may_win ? of_axis[axis].plane : std::numeric_limits<float>::quiet_NaN();
    const float width = map.width[axis] / static_cast<float>(config.bin_count);
    from[axis] = plane - width;
    to[axis] = plane + width;
  }
  const SahFaces(&faces)[3] =
      survey.faces({from[0], from[1], from[2]}, {to[0], to[1], to[2]}, faces_max);
  for (int axis = 0; axis < 3; ++axis) sweep(faces[axis], axis, count, judge);
  return judge.best;
}

template SahSplit choose_split(const WholeBoxes&, const Bounds3f&, const KdBuildConfig&,
                               SahScratch&, std::size_t, int);
template SahSplit choose_split(const PartBoxes&, const Bounds3f&, const KdBuildConfig&, SahScratch&,
                               std::size_t, int);

}  // namespace tessera::core
