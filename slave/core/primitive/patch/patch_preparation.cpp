// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_preparation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_bounds.h"
#include "slave/core/primitive/patch/sub_patch_range.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {
namespace {

// Of a part that is cut by trims: of what is left out, for halves of it to be worth their memory.
constexpr double kShareOut = 0.5;

constexpr double kInf = std::numeric_limits<double>::infinity();

// w (S - middle) and w over one part. The middle has numbers of float32, so that its products with
// weights are exact, and errors are relative to the patch's size wherever it lies.
struct PartNets {
  PatchNet x[3], w;

  Vec3d point(int i, int j) const {
    const double weight = w.c[i][j];
    return {x[0].c[i][j] / weight, x[1].c[i][j] / weight, x[2].c[i][j] / weight};
  }
};

struct DoubleBox {
  double low[3] = {kInf, kInf, kInf}, high[3] = {-kInf, -kInf, -kInf};

  explicit DoubleBox(const PartNets& nets) {
    for (int i = 0; i <= nets.w.m; ++i)
      for (int j = 0; j <= nets.w.n; ++j) {
        const Vec3d p = nets.point(i, j);
        for (int a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], p[a]);
          high[a] = std::max(high[a], p[a]);
        }
      }
  }
  double size() const { return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }
};

// Toward infinity: the nearest float32, and one further.
float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

class Splitter {
 public:
  Splitter(const Patch& patch, std::uint32_t number, const PatchSplitting& splitting,
           SubPatches& to)
      : patch_(patch), number_(number), splitting_(splitting), to_(to) {}

  void run(Kept kept) {
    const int m = patch_.degree_u, n = patch_.degree_v;
    take_points(patch_, points_);
    PartNets nets;
    for (PatchNet* net : {&nets.x[0], &nets.x[1], &nets.x[2], &nets.w}) *net = net_of(m, n);
    const PatchJet jet = evaluate(patch_, points_, 0.5, 0.5);
    for (int a = 0; a < 3; ++a) middle_[a] = static_cast<float>(jet.point[a]);
    for (int i = 0; i <= m; ++i)
      for (int j = 0; j <= n; ++j) {
        const PatchPoint& p = points_[(n + 1) * i + j];
        nets.w.c[i][j] = p.x[3];
        for (int a = 0; a < 3; ++a) nets.x[a].c[i][j] = p.x[a] - middle_[a] * p.x[3];
      }
    size_ = DoubleBox(nets).size();
    error_ = kNetError * std::max({size_of(nets.x[0]), size_of(nets.x[1]), size_of(nets.x[2])});
    split_part(nets, SubPatch{}, kept);
  }

 private:
  struct Verdict {
    double worst = kInf;  // the radius that is left open, over that which is asked for
    bool splits_u = true;
    bool is_long_by_u = true;
  };

  Kept kept_of(const SubPatch& part) const {
    const SubPatchRange range(part);
    return patch_.trims->kept_of(patch_.trimmed_as,
                                 {range.middle_u - range.half_u, range.middle_u + range.half_u,
                                  range.middle_v - range.half_v, range.middle_v + range.half_v});
  }

  // The share of places of a part, in even steps, that are left out.
  double share_left_out(const SubPatch& part) const {
    constexpr int kSide = 8;
    const SubPatchRange range(part);
    int count = 0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const double x = (2 * i + 1.0) / kSide - 1, y = (2 * j + 1.0) / kSide - 1;
        count += !patch_.trims->is_kept(patch_.trimmed_as, range.middle_u + range.half_u * x,
                                        range.middle_v + range.half_v * y);
      }
    return count / double{kSide * kSide};
  }

  // Recursion: at most twice the larger level deep. kept: what is known of a part that holds it.
  void split_part(const PartNets& nets, SubPatch part, Kept kept) {
    if (kept == Kept::kSome) kept = kept_of(part);
    if (kept == Kept::kNone) return;
    part.patch = number_;
    part.is_trimmed = kept == Kept::kSome;
    Verdict verdict = fill(part, nets);
    const DoubleBox box(nets);
    const bool is_done = verdict.worst <= 1;
    const int most = !is_done ? splitting_.level_max
                     : part.is_trimmed && share_left_out(part) >= kShareOut
                         ? splitting_.trim_level_max
                         : 0;
    if (is_done) verdict.splits_u = verdict.is_long_by_u;
    if (part.level_u >= most) verdict.splits_u = false;
    if (part.level_v >= most) verdict.splits_u = true;
    const bool is_last =
        (part.level_u >= most && part.level_v >= most) || box.size() < splitting_.smallest * size_;
    if (is_last) {
      to_.parts.push_back(part);
      to_.boxes.push_back(outward(nets, box));
      return;
    }
    for (const bool is_high : {false, true}) {
      PartNets half = nets;
      for (PatchNet* net : {&half.x[0], &half.x[1], &half.x[2], &half.w})
        verdict.splits_u ? cut_u(*net, 0.5, is_high) : cut_v(*net, 0.5, is_high);
      SubPatch other{};
      other.column = part.column;
      other.row = part.row;
      other.level_u = part.level_u;
      other.level_v = part.level_v;
      std::uint16_t& place = verdict.splits_u ? other.column : other.row;
      place = static_cast<std::uint16_t>(2 * place + (is_high ? 1 : 0));
      ++(verdict.splits_u ? other.level_u : other.level_v);
      split_part(half, other, kept);
    }
  }

  // Fills in the frame and the bounds.
  Verdict fill(SubPatch& part, const PartNets& nets) {
    const SubPatchRange range(part);
    const PatchJet jet = evaluate(patch_, points_, range.middle_u, range.middle_v);
    const Vec3d a = range.half_u * Vec3d{jet.du[0], jet.du[1], jet.du[2]};
    const Vec3d b = range.half_v * Vec3d{jet.dv[0], jet.dv[1], jet.dv[2]};
    const Vec3d from_middle{jet.point[0] - middle_[0], jet.point[1] - middle_[1],
                            jet.point[2] - middle_[2]};
    const Vec3d normal = cross(a, b);
    const double area = length(normal);
    const bool is_long_by_u = length(a) >= length(b);
    Verdict verdict{kInf, is_long_by_u, is_long_by_u};
    // Below these the derivatives are parallel, or noise.
    if (!(area > 0x1p-30 * length(a) * length(b) && area > 0x1p-60 * size_ * size_)) return verdict;
    const Vec3d n = (1 / area) * normal;
    const Vec3d rows[3] = {(1 / area) * cross(b, n), (1 / area) * cross(n, a), n};
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) part.frame[r][k] = static_cast<float>(rows[r][k]);
    // The centre lies in the middle of the range along the normal, so that reach_n is least.
    double low = kInf, high = -kInf;
    for (int i = 0; i <= nets.w.m; ++i)
      for (int j = 0; j <= nets.w.n; ++j) {
        const double depth = dot(n, nets.point(i, j) - from_middle);
        low = std::min(low, depth);
        high = std::max(high, depth);
      }
    for (int k = 0; k < 3; ++k)
      part.centre[k] = static_cast<float>(middle_[k] + from_middle[k] + 0.5 * (low + high) * n[k]);
    const SubPatchBounds bounds = local_bounds(part, nets);
    store(bounds, part);
    if (!part.has_frame) return verdict;
    return judged(bounds, rows, nets, is_long_by_u);
  }

  SubPatchBounds local_bounds(const SubPatch& part, const PartNets& nets) const {
    PatchNet local[3];
    double error[3] = {};
    for (int r = 0; r < 3; ++r) {
      local[r] = net_of(nets.w.m, nets.w.n);
      for (int k = 0; k < 3; ++k) {
        const double f = part.frame[r][k], shift = double{part.centre[k]} - middle_[k];
        // Twice: the sums below have 7 roundings of numbers not larger than those in error_.
        error[r] += 2 * std::fabs(f) * error_;
        for (int i = 0; i <= nets.w.m; ++i)
          for (int j = 0; j <= nets.w.n; ++j)
            local[r].c[i][j] += f * (nets.x[k].c[i][j] - shift * nets.w.c[i][j]);
      }
    }
    return bounds_of(local, nets.w, patch_.is_rational, error);
  }

  // A part whose frame or bounds are beyond float32 has none: the complete solver decides it.
  static void store(const SubPatchBounds& bounds, SubPatch& part) {
    bool is_finite = true;
    for (int r = 0; r < 3; ++r) {
      part.reach[r] = rounded_up(bounds.reach[r]);
      part.second[0][r] = rounded_up(bounds.xx[r]);
      part.second[1][r] = rounded_up(bounds.xy[r]);
      part.second[2][r] = rounded_up(bounds.yy[r]);
      is_finite = is_finite && std::isfinite(part.reach[r]) && std::isfinite(part.centre[r]);
      for (int k = 0; k < 3; ++k)
        is_finite =
            is_finite && std::isfinite(part.second[k][r]) && std::isfinite(part.frame[r][k]);
    }
    part.has_frame = is_finite;
    // Those that are infinite would be a border's (fat_border.h).
    if (!is_finite) std::fill_n(&part.second[0][0], 9, 0.0f);
  }

  Verdict judged(const SubPatchBounds& bounds, const Vec3d (&rows)[3], const PartNets& nets,
                 bool is_long_by_u) const {
    double radius = 0, in_x = 0, in_y = 0;
    for (int r = 0; r < 2; ++r) {
      const double slope = splitting_.slope * length(rows[r]);
      radius = std::max(radius, bounds.reach[r] + slope * bounds.reach[2]);
      in_x = std::max(in_x, bounds.xx[r] + slope * bounds.xx[2]);
      in_y = std::max(in_y, bounds.yy[r] + slope * bounds.yy[2]);
    }
    Verdict verdict{radius / splitting_.radius, in_x >= in_y, is_long_by_u};
    // Towards a border that is one point, halves across it are of no use.
    if (is_collapsed(nets, false)) {
      verdict.splits_u = false;
    } else if (is_collapsed(nets, true)) {
      verdict.splits_u = true;
    }
    return verdict;
  }

  // Whether one of the two borders where u (or v) is constant is one point.
  bool is_collapsed(const PartNets& nets, bool of_u) const {
    const int steps = of_u ? nets.w.n : nets.w.m;
    for (const int at : {0, of_u ? nets.w.m : nets.w.n}) {
      double spread = 0;
      const Vec3d first = of_u ? nets.point(at, 0) : nets.point(0, at);
      for (int q = 1; q <= steps; ++q)
        spread = std::max(spread, length((of_u ? nets.point(at, q) : nets.point(q, at)) - first));
      if (spread <= 0x1p-40 * size_) return true;
    }
    return false;
  }

  // The hull of the net, which holds the part of the surface; wider by what the net may be off by,
  // and by a part of itself, for the overlap of kPatchOverlap with neighbours.
  Bounds3f outward(const PartNets& nets, const DoubleBox& box) const {
    const NetRange w = range_of(nets.w);
    const double error = 4 * (error_ + kNetError * size_ * w.high) / w.low;
    float low[3] = {}, high[3] = {};
    for (int a = 0; a < 3; ++a) {
      const double wide = (box.high[a] - box.low[a]) * 0x1p-12 + error;
      low[a] = -rounded_up(-(box.low[a] - wide + middle_[a]));
      high[a] = rounded_up(box.high[a] + wide + middle_[a]);
    }
    return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
  }

  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  const std::uint32_t number_;
  const PatchSplitting splitting_;
  SubPatches& to_;
  double middle_[3] = {};
  double size_ = 0, error_ = 0;
};

}  // namespace

void split_patch(const Patch& patch, std::uint32_t number, const PatchSplitting& splitting,
                 SubPatches& to) {
  TESSERA_CHECK(splitting.level_max >= 0 && splitting.level_max <= kSubPatchLevelMax);
  Splitter(patch, number, splitting, to).run(Kept::kAll);
}

void split_trimmed_patch(const Patch& patch, std::uint32_t number, const PatchSplitting& splitting,
                         SubPatches& to) {
  TESSERA_CHECK(splitting.level_max >= 0 && splitting.level_max <= kSubPatchLevelMax);
  TESSERA_CHECK(splitting.trim_level_max <= kSubPatchLevelMax);
  Splitter(patch, number, splitting, to).run(Kept::kSome);
}

}  // namespace tessera::core
