// SPDX-License-Identifier: Apache-2.0
// The text of the decision, for registers of doubles.
// Threads. Pure functions.
#if defined(TESSERA_TESTS_PATCH_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_TESTS_PATCH_LANES_INL_H_
#undef TESSERA_TESTS_PATCH_LANES_INL_H_
#else
#define TESSERA_TESTS_PATCH_LANES_INL_H_
#endif

#include "slave/core/primitive/patch/patch_decision-inl.h"
#include "tests/property/patch/patch_lanes_layout.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <bool kRational, int kM, int kN>
HWY_INLINE void decide_rows(const Patch& patch, const SubPatch& part, const PatchPoint* local,
                            const PatchLaneRays& rays, PatchLaneAnswers& answers) {
  constexpr size_t kWidth = kLanesOf<Doubles>;
  answers.is_hit = answers.is_undecided = 0;
  for (size_t at = 0; at < kPatchLanes; at += kWidth) {
    Doubles origin[3] = {}, direction[3] = {};
    for (int k = 0; k < 3; ++k) {
      origin[k] = load<Doubles>(rays.origin[k] + at);
      direction[k] = load<Doubles>(rays.direction[k] + at);
    }
    const PatchDecision<Doubles> answer = decided<Doubles, kRational, kM, kN>(
        part, local, patch.degree_u, patch.degree_v, patch.extent, origin, direction);
    store(answer.t, answers.t + at);
    store(answer.u, answers.u + at);
    store(answer.v, answers.v + at);
    answers.is_hit |= bits_of<Doubles>(answer.is_hit) << at;
    answers.is_undecided |= bits_of<Doubles>(answer.is_undecided) << at;
  }
}

inline void decide_patch_lanes(const Patch& patch, const SubPatch& part, const PatchLaneRays& rays,
                               PatchLaneAnswers& answers) {
  PatchPoint local[kPatchPointsMax];
  local_points(part, patch, local);
  const bool is_bicubic = patch.degree_u == 3 && patch.degree_v == 3;
  if (patch.is_rational) {
    decide_rows<true, 0, 0>(patch, part, local, rays, answers);
  } else if (is_bicubic) {
    decide_rows<false, 3, 3>(patch, part, local, rays, answers);
  } else {
    decide_rows<false, 0, 0>(patch, part, local, rays, answers);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
