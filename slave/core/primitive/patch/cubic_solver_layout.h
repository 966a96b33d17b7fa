// SPDX-License-Identifier: Apache-2.0
// What the complete solver of degrees up to 3 is given and what it answers.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

struct SolvedPatch {
  double t, u, v;
  int box_count;  // looked at
  bool is_hit, is_exhausted;
};

// Finds the nearest root with t in [t_min, t_max]. Shape: origin, direction [3].
// Requires: degrees up to kCubicMax; finite numbers, and a direction that is not zero.
using CubicSolverCall = void (*)(const Patch& patch, const SubPatch& part, const float* origin,
                                 const float* direction, const float* t_range, SolvedPatch& to);

// A ray and a sub-patch that the complete solver is to decide.
struct PatchQuestion {
  const Patch* patch;
  const SubPatch* part;
  float origin[3], direction[3];
  float t_range[2];
  bool is_any = false;  // any hit in t_range will do
};

// The same for any number of questions, side by side. Shape: questions, to [count].
using CubicSolversCall = void (*)(const PatchQuestion* questions, int count, SolvedPatch* to);

// What float32 proves of a question: is_hit and t are those of the complete solver, t as a float32.
// Where any hit will do, t is only known to be in t_range.
struct QuickAnswer {
  bool is_known, is_hit;
  float t;  // of hits
};

// Answers what it can of questions whose t_range has no end, or of which any hit will do. Shape:
// questions, to [count], count up to kQuickMost. Requires: polynomial bicubic patches, sub-patches
// with frames.
using QuickAnswersCall = void (*)(const PatchQuestion* questions, int count, QuickAnswer* to);

inline constexpr int kQuickMost = 64;
inline constexpr int kCubicMax = 3;
inline constexpr int kSolverBoxesMax = 1024;

}  // namespace tessera::core
