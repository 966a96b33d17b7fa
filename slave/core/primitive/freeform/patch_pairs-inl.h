// SPDX-License-Identifier: Apache-2.0
// A register of rays, each with a sub-patch of its own, decided at once: for rays that have nothing
// in common. The operations are those of patch_hit(). Only for polynomial bicubic patches.
//
// Threads. One traversal owns one.
#include <stddef.h>

#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_PATCH_PAIRS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_PAIRS_INL_H_
#undef TESSERA_CORE_PATCH_PAIRS_INL_H_
#else
#define TESSERA_CORE_PATCH_PAIRS_INL_H_
#endif

#include "slave/core/primitive/patch/lane_rows-inl.h"
#include "slave/core/primitive/patch/patch_decision-inl.h"
#include "slave/core/ray/one_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Whether it is a span of a widened border (fat_border.h), whose second derivatives have no bound:
// a decision would leave all of its rays open.
HWY_INLINE bool is_border_span(const SubPatch& part) { return part.second[0][0] > 0x1.fffffep127f; }
// The next of the spans that one in the hierarchy stands for, or null. Requires: is_border_span().
HWY_INLINE const SubPatch* next_beside(const SubPatch& part) {
  return part.row == 0 ? nullptr : &part + static_cast<int16_t>(part.row);
}

// Control points of a register of nets, one a lane.
struct PointsInLanes {
  const double (*x)[kLanesOf<Doubles>];  // [point and axis]
};
template <class T>
HWY_INLINE T component_of(PointsInLanes points, int number, int a) {
  return load<T>(points.x[3 * number + a]);
}

class PatchPairs {
 public:
  static constexpr int kWidth = static_cast<int>(kLanesOf<Doubles>);

  static HWY_INLINE bool takes(const Patch& patch, const SubPatch& part) {
    return !patch.is_rational && patch.degree_u == 3 && patch.degree_v == 3 && part.has_frame &&
           !is_border_span(part);
  }

  // Whether rays are left to the complete solver at once.
  static HWY_INLINE bool is_to_be_solved(const Patch& patch, const SubPatch& part) {
    return part.has_frame && !is_border_span(part) && is_left_to_solver(patch, part);
  }

  // The ray, the patch and the sub-patch have to stay until decide(). Requires: takes().
  HWY_INLINE void put(int lane, const OneRay& ray, const Patch& patch, const SubPatch& part) {
    static_assert(offsetof(SubPatch, second) == (kPartNumbers - 9) * sizeof(float));
    part_[lane] = reinterpret_cast<const float*>(&part);
    number_[lane] = patch.numbers;
    fetch_lines<3>(patch.numbers);
    for (int a = 0; a < 3; ++a) {
      ray_[a][lane] = ray.origin[a];
      ray_[3 + a][lane] = ray.direction[a];
    }
    const double half_u = 1.0 / (2u << part.level_u), half_v = 1.0 / (2u << part.level_v);
    const double range[5] = {patch.extent, half_u, half_v, (2 * part.column + 1) * half_u,
                             (2 * part.row + 1) * half_v};
    for (int k = 0; k < 5; ++k) range_[k][lane] = range[k];
  }
  // Fills the lanes from `count` on with what the lane before has.
  HWY_INLINE void fill(int count) {
    for (int lane = count; lane < kWidth; ++lane) {
      part_[lane] = part_[count - 1];
      number_[lane] = number_[count - 1];
      for (auto& row : ray_) row[lane] = row[count - 1];
      for (auto& row : range_) row[lane] = row[count - 1];
    }
  }
  // Requires: all lanes are there. They have to be put anew after it.
  HWY_NOINLINE PatchDecision<Doubles> decide() {
    Doubles of_part[kPartNumbers] = {};
    each_row<kPartNumbers>(part_, [&](int k, Doubles x) HWY_ATTR { of_part[k] = x; });
    PartNumbers<Doubles> part = {};
    for (int r = 0; r < 3; ++r) {
      part.centre[r] = of_part[9 + r];
      part.reach[r] = of_part[12 + r];
      for (int k = 0; k < 3; ++k) {
        part.frame[r][k] = of_part[3 * r + k];
        part.second[r][k] = of_part[15 + 3 * r + k];
      }
    }
    part.extent = load<Doubles>(range_[0]);
    part.half_u = load<Doubles>(range_[1]);
    part.half_v = load<Doubles>(range_[2]);
    part.middle_u = load<Doubles>(range_[3]);
    part.middle_v = load<Doubles>(range_[4]);
    each_row<48>(number_, [&](int k, Doubles x) HWY_ATTR { store(x, point_[k]); });
    // As local_points(), with weights of 1.
    for (int p = 0; p < 16; ++p) {
      Doubles d[3] = {};
      for (int a = 0; a < 3; ++a) d[a] = load<Doubles>(point_[3 * p + a]) - part.centre[a];
      for (int r = 0; r < 3; ++r)
        store(part.frame[r][0] * d[0] + part.frame[r][1] * d[1] + part.frame[r][2] * d[2],
              point_[3 * p + r]);
    }
    Doubles origin[3] = {}, direction[3] = {};
    for (int a = 0; a < 3; ++a) {
      origin[a] = wide(ray_[a]);
      direction[a] = wide(ray_[3 + a]);
    }
    return decided_of<Doubles, false, 3, 3>(part, PointsInLanes{point_}, 3, 3, origin, direction);
  }

 private:
  static constexpr int kPartNumbers = 24;  // frame, centre, reach, second of a SubPatch

  static HWY_INLINE Doubles wide(const float* from) {
    return convert<Doubles>(load<FloatOf<Doubles>>(from));
  }

  const float* part_[kWidth];
  const float* number_[kWidth];           // of control points
  alignas(64) float ray_[6][kWidth];      // origin, direction
  alignas(64) double range_[5][kWidth];   // extent, halves, middles
  alignas(64) double point_[48][kWidth];  // control points, then in the frame
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
