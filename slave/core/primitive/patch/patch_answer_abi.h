// SPDX-License-Identifier: Apache-2.0
// The answer of one sub-patch to one ray, as traversals ask for it.
//
// Declarations only: kernel files, which are compiled once per instruction set, may include this.
// Threads. Each thread has memory of its own for the complete solver.
#pragma once

#include "slave/core/primitive/patch/cubic_solver_layout.h"

namespace tessera::core {

struct PatchAnswer {
  bool is_hit;
  float t;      // rounded to nearest
  double u, v;  // the patch's own
};

// The nearest hit from t_min on, by patch_hit(), that trims keep; rays that end before it are the
// caller's to see.
// Shape: origin [3], direction [3].
PatchAnswer patch_answer(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, float t_min);

// The same where it is known that the decision leaves the ray undecided, or has no frame: only the
// complete solver is asked. Requires: finite numbers, and a direction that is not zero.
PatchAnswer solved_answer(const Patch& patch, const SubPatch& part, const float* origin,
                          const float* direction, float t_min);

// is_hit and t of the same for several, whose t_range begins with t_min and has no end, or of which
// any hit will do: the t that is told may be another one's then, and callers compare it anyway.
// Shape: questions, answers [count], count up to kPatchQuestionsMax.
inline constexpr int kPatchQuestionsMax = 64;
void solved_answers(const PatchQuestion* questions, int count, PatchAnswer* answers);

// The same in two parts, for callers that put off what takes long: first what the filter in float32
// proves (quick_cubics-inl.h), and then the others, for which the complete solver has registers.
// Returns: the bits of the others, whose answers are not written.
uint64_t filtered_answers(const PatchQuestion* questions, int count, PatchAnswer* answers);
void unfiltered_answers(const PatchQuestion* questions, int count, PatchAnswer* answers);

// Whether the patch is there at (u, v). To be asked for hits of sub-patches that are trimmed.
bool is_kept(const Patch& patch, double u, double v);

// Those of some hits where it is there. Shape: u and v of hit i, for each bit i that is set.
uint32_t kept_of_hits(const Patch& patch, const double* u, const double* v, uint32_t hits);

}  // namespace tessera::core
