// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "slave/core/primitive/patch/cubic_solver_abi.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/patch_hit.h"
#include "slave/core/primitive/patch/trim_set.h"

namespace tessera::core {
namespace {

// Roots of one ray in one sub-patch that are looked at, where all before them are left out. A
// patch of degrees m, n has 2 m n at most; sub-patches that the solver takes have some.
constexpr int kRootsMax = 64;

CompleteSolver& solver_of_thread() {
  thread_local const auto solver = std::make_unique<CompleteSolver>();
  return *solver;
}

PatchRay ray_of(const float* origin, const float* direction, float t_min) {
  return {{origin[0], origin[1], origin[2]},
          {direction[0], direction[1], direction[2]},
          t_min,
          std::numeric_limits<float>::infinity()};
}

PatchAnswer beside_border(const Patch& patch, const SubPatch& part, const float* origin,
                          const float* direction, float t_min) {
  const FatHit hit = fat_border_hit(patch, part, origin, direction, t_min);
  return {hit.is_hit, hit.t, hit.u, hit.v};
}

// The first hit that trims keep. find: the first hit of a ray, which may have others behind it.
template <class Find>
PatchAnswer first_kept(const Patch& patch, const SubPatch& part, PatchRay ray, const Find& find) {
  for (int root = 0; root < kRootsMax; ++root) {
    const PatchHit hit = find(ray);
    if (!hit.is_hit) return {};
    const auto t = static_cast<float>(hit.t);
    if (!part.is_trimmed || is_kept(patch, hit.u, hit.v)) return {true, t, hit.u, hit.v};
    // The least number behind this root.
    ray.t_min = double{t} > hit.t ? t : std::nextafter(t, ray.t_max);
  }
  return {};
}

PatchAnswer solved_alone(const PatchQuestion& q) {
  return solved_answer(*q.patch, *q.part, q.origin, q.direction, q.t_range[0]);
}

bool is_for_cubics(const PatchQuestion& q) {
  return std::max(q.patch->degree_u, q.patch->degree_v) <= kCubicMax && !is_fat_border(*q.part);
}

// What trims leave of the first root. What lies behind one that is left out is for the few.
PatchAnswer kept_answer(const PatchQuestion& q, const SolvedPatch& hit) {
  if (!hit.is_hit) return {};
  if (q.part->is_trimmed && !is_kept(*q.patch, hit.u, hit.v)) return solved_alone(q);
  return {true, static_cast<float>(hit.t), hit.u, hit.v};
}

bool is_for_filter(const PatchQuestion& q) {
  const Patch& patch = *q.patch;
  return patch.degree_u == 3 && patch.degree_v == 3 && !patch.is_rational && q.part->has_frame &&
         !is_fat_border(*q.part);
}

}  // namespace

PatchAnswer patch_answer(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, float t_min) {
  if (is_fat_border(part)) return beside_border(patch, part, origin, direction, t_min);
  return first_kept(patch, part, ray_of(origin, direction, t_min), [&](const PatchRay& ray) {
    return patch_hit(patch, part, ray, solver_of_thread());
  });
}

PatchAnswer solved_answer(const Patch& patch, const SubPatch& part, const float* origin,
                          const float* direction, float t_min) {
  if (is_fat_border(part)) return beside_border(patch, part, origin, direction, t_min);
  return first_kept(patch, part, ray_of(origin, direction, t_min), [&](const PatchRay& ray) {
    return solver_of_thread().solve(patch, part, ray);
  });
}

uint64_t filtered_answers(const PatchQuestion* questions, int count, PatchAnswer* answers) {
  static const QuickAnswersCall answer = widest_quick_answers();
  static_assert(kPatchQuestionsMax <= kQuickMost && kPatchQuestionsMax <= 64);
  uint64_t left = 0;
  int number[kPatchQuestionsMax], asked_count = 0;
  PatchQuestion asked[kPatchQuestionsMax];
  QuickAnswer to[kPatchQuestionsMax];
  for (int k = 0; k < count; ++k) {
    if (is_for_filter(questions[k])) {
      number[asked_count] = k;
      asked[asked_count++] = questions[k];
    } else {
      left |= uint64_t{1} << k;
    }
  }
  answer(asked, asked_count, to);
  for (int i = 0; i < asked_count; ++i) {
    const int k = number[i];
    // Trims need the solver's own u and v.
    if (!to[i].is_known || (to[i].is_hit && questions[k].part->is_trimmed)) {
      left |= uint64_t{1} << k;
    } else {
      answers[k] = {to[i].is_hit, to[i].t, 0, 0};
    }
  }
  return left;
}

void unfiltered_answers(const PatchQuestion* questions, int count, PatchAnswer* answers) {
  static const CubicSolversCall solve_cubics = widest_cubic_solvers();
  PatchQuestion cubic[kPatchQuestionsMax];
  int number[kPatchQuestionsMax], cubic_count = 0;
  for (int k = 0; k < count; ++k) {
    if (is_for_cubics(questions[k])) {
      number[cubic_count] = k;
      cubic[cubic_count] = questions[k];
      // What ends a ray is a float32, and roots are rounded before they are compared with it.
      cubic[cubic_count++].t_range[1] = std::numeric_limits<float>::infinity();
    } else {
      answers[k] = solved_alone(questions[k]);
    }
  }
  SolvedPatch solved[kPatchQuestionsMax];
  solve_cubics(cubic, cubic_count, solved);
  for (int k = 0; k < cubic_count; ++k) answers[number[k]] = kept_answer(cubic[k], solved[k]);
}

void solved_answers(const PatchQuestion* questions, int count, PatchAnswer* answers) {
  PatchQuestion asked[kPatchQuestionsMax];
  PatchAnswer to[kPatchQuestionsMax];
  int number[kPatchQuestionsMax], asked_count = 0;
  for (uint64_t left = filtered_answers(questions, count, answers); left != 0; left &= left - 1) {
    number[asked_count] = std::countr_zero(left);
    asked[asked_count] = questions[number[asked_count]];
    ++asked_count;
  }
  if (asked_count == 0) return;
  unfiltered_answers(asked, asked_count, to);
  for (int i = 0; i < asked_count; ++i) answers[number[i]] = to[i];
}

bool is_kept(const Patch& patch, double u, double v) {
  return patch.trims == nullptr || patch.trims->is_kept(patch.trimmed_as, u, v);
}

std::uint32_t kept_of_hits(const Patch& patch, const double* u, const double* v,
                           std::uint32_t hits) {
  if (patch.trims == nullptr) return hits;
  TrimPlace places[32];
  std::size_t count = 0;
  for (std::uint32_t left = hits; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    places[count++] = {u[i], v[i]};
  }
  const std::uint64_t kept = patch.trims->kept(patch.trimmed_as, std::span(places, count));
  count = 0;
  for (std::uint32_t left = hits; left != 0; left &= left - 1, ++count) {
    if ((kept >> count & 1) == 0) hits ^= left & (~left + 1);
  }
  return hits;
}

}  // namespace tessera::core
