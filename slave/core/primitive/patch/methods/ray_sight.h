// SPDX-License-Identifier: Apache-2.0
// What methods for patches share: a ray as two planes that meet in it, how far from it a root may
// be, and the nearest root so far.
//
// A root is a point of the surface within kMethodAccuracy of the patch's size from the ray: the
// accuracy threshold of the thesis (6.4.1), where it was 1e-3. At 2^-28 it is below what t is
// rounded by to float32, and roots of neighbours at a border are nearer to each other than ranges
// overlap.
//
// Threads. Plain values.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_range.h"

namespace tessera::core {

inline constexpr double kMethodAccuracy = 0x1p-28;
// By how much of its half width a part's range is widened, so that neighbours overlap by more than
// what two methods' roots at a border may be apart.
inline constexpr double kMethodOverlap = 0x1p-24;

struct RaySight {
  Vec3d origin, direction;
  Vec3d normal[2];    // unit, across the ray and each other
  double per_square;  // 1 / D . D

  RaySight(const float* o, const float* d)
      : origin{o[0], o[1], o[2]},
        direction{d[0], d[1], d[2]},
        per_square(1 / dot(direction, direction)) {
    int small = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(direction[k]) < std::fabs(direction[small])) small = k;
    const Vec3d axis{small == 0 ? 1.0 : 0.0, small == 1 ? 1.0 : 0.0, small == 2 ? 1.0 : 0.0};
    normal[0] = normalize(cross(axis, direction));
    normal[1] = normalize(cross(direction, normal[0]));
  }

  // t of the point of the ray that is nearest to a point of the surface.
  double depth(Vec3d from_origin) const { return dot(direction, from_origin) * per_square; }
};

// The nearest root of a ray in a sub-patch, among those from t_min on that trims keep.
class NearestRoot {
 public:
  NearestRoot(const Patch& patch, const SubPatch& part, const RaySight& sight, float t_min)
      : patch_(patch), part_(part), sight_(sight), range_(part), t_min_(double{t_min}) {}

  const SubPatchRange& range() const { return range_; }

  // Takes the root at (u, v) of the patch, which is brought into the sub-patch's range.
  void add(double u, double v) {
    u = within(u, range_.middle_u, range_.half_u);
    v = within(v, range_.middle_v, range_.half_v);
    const PatchJet jet = evaluate(patch_, u, v);
    const Vec3d point{jet.point[0], jet.point[1], jet.point[2]};
    add(sight_.depth(point - sight_.origin), u, v);
  }
  void add(double t, double u, double v) {
    if (!(t >= t_min_) || (best_.is_hit && !(t < nearest_))) return;
    if (part_.is_trimmed && !is_kept(patch_, u, v)) return;
    best_ = {true, static_cast<float>(t), u, v};
    nearest_ = t;
  }

  const PatchAnswer& answer() const { return best_; }

 private:
  static double within(double x, double middle, double half) {
    return std::clamp(x, middle - half, middle + half);
  }

  const Patch& patch_;
  const SubPatch& part_;
  const RaySight& sight_;
  const SubPatchRange range_;
  double t_min_, nearest_ = 0;
  PatchAnswer best_{false, 0, 0, 0};
};

}  // namespace tessera::core
