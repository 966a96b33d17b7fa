// SPDX-License-Identifier: Apache-2.0
// What tests a sub-patch against the rays of a packet, in world space. Rays that may meet it
// (patch_filter-inl.h) are put side by side and decided a register at a time, by the operations of
// patch_hit(); what that leaves undecided goes to the complete solver.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/shapes_layout.h"

#if defined(TESSERA_CORE_PATCH_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_PACKET_INL_H_
#undef TESSERA_CORE_PATCH_PACKET_INL_H_
#else
#define TESSERA_CORE_PATCH_PACKET_INL_H_
#endif

#include "slave/core/primitive/freeform/patch_filter-inl.h"
#include "slave/core/primitive/freeform/patch_pairs-inl.h"
#include "slave/core/primitive/freeform/points_in_frame-inl.h"
#include "slave/core/primitive/patch/patch_decision-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// An item of MixedPacketLeaf.
template <int W, bool kAny, class Rays, template <int, bool> class Test>
class PatchPacketTest {
 public:
  HWY_INLINE PatchPacketTest(Rays& rays, Test<W, kAny>& test) : rays_(rays), test_(test) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() {
    if constexpr (kAsksRows) rows_.set_to(rays_);
  }
  HWY_INLINE bool test(const TrianglesAndPatches<W>& shapes, uint32_t number) {
    return test(shapes.patches, shapes.parts[number]);
  }
  // The same, wherever they are; they stay until settle_waiting(). patches: those that sub-patches
  // name.
  HWY_NOINLINE bool test(const Patch* patches, const SubPatch& part);
  // Has all answered that waits. Returns: whether some ray has a new best hit.
  HWY_INLINE bool settle_waiting() {
    bool has_hit = waiting_.count != 0 && ask_waiting();
    if (open_.count != 0) has_hit |= ask_open();
    return has_hit;
  }

 private:
  // Questions to the complete solver are put together: it keeps its lanes busy where there are
  // several times as many, and rays learn of hits the later the more there are.
  static constexpr int kWorthAsking = 24;
  // A filter answers most of them. The few that it leaves open fill the solver's lanes only where
  // those of several batches are put together.
  static constexpr int kOpenWorthAsking = 8;

  // Rays that may meet a sub-patch, side by side; the last ones are repeated to fill a register.
  struct Candidates {
    int count = 0;
    uint8_t ray[kPacketRays];
    alignas(64) double origin[3][kPacketRays + 8], direction[3][kPacketRays + 8];
  };

  // Rays, and what they ask.
  struct Questions {
    int count = 0;
    uint8_t ray[kPatchQuestionsMax];
    PatchQuestion question[kPatchQuestionsMax];

    HWY_INLINE bool has_room(int more) const { return count + more <= kPatchQuestionsMax; }
    // Returns: what the ray asks, to be set. Requires: there is room.
    HWY_INLINE PatchQuestion& add(size_t from) {
      ray[count] = static_cast<uint8_t>(from);
      return question[count++];
    }
  };

  using Filter = PatchFilter<Rays>;
  // Rows of shadow rays reach too far to be worth it.
  static constexpr bool kAsksRows = kHasRows<Rays> && !kAny;

  // The rays of some rows that may meet a sub-patch with a frame. more: as in PatchFilter.
  template <class More>
  static HWY_INLINE uint64_t possible_rays(const Filter& filter, uint64_t rows, const More& more) {
    uint64_t possible = 0;
    for (; rows != 0; rows &= rows - 1) {
      const size_t at = kLaneCount * static_cast<size_t>(__builtin_ctzll(rows));
      possible |= uint64_t{filter.possible(at, more)} << at;
    }
    return possible;
  }
  HWY_INLINE void gather(uint64_t possible, Candidates& rays) const;
  template <bool kRational, int kM, int kN>
  HWY_NOINLINE bool decide(const Patch& patch, const SubPatch& part, const Candidates& rays);
  // Has the complete solver asked for the rays of these bits, sooner or later.
  // Requires: there are some.
  HWY_NOINLINE bool ask_all(const Patch& patch, const SubPatch& part, uint64_t possible);
  HWY_NOINLINE bool ask_waiting();
  HWY_NOINLINE bool ask_open();
  HWY_INLINE bool take(const SubPatch& part, size_t ray, float t) {
    if (!kAny) test_.settle(ray);
    return rays_.template take<kAny>(ray, t, least_t(rays_, ray), part.primitive);
  }

  Rays& rays_;
  Test<W, kAny>& test_;
  FanRows rows_;
  Questions waiting_;
  Questions open_;  // of those that waited
};

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::test(const Patch* patches, const SubPatch& part) {
  const Patch& patch = patches[part.patch];
  uint64_t possible = 0;
  if (part.has_frame) {
    const Filter filter(rays_, part);
    uint64_t rows = FanRows::kAll;
    if constexpr (kAsksRows) rows = filter.possible_rows(rows_);
    // As for triangles: what a candidate costs, and each row of it.
    rays_.work_left -= 2 + __builtin_popcountll(rows);
    if (rows == 0) return false;
    const bool is_border = is_border_span(part);
    possible = is_border                       ? possible_rays(filter, rows, BorderBend(part))
               : PatchHull::helps(patch, part) ? possible_rays(filter, rows, PatchHull(patch, part))
                                               : possible_rays(filter, rows, NothingMore());
    possible &= ~rays_.excluding(possible, static_cast<int32_t>(part.primitive));
    if (possible == 0) return false;
    rays_.work_left -= 2 * __builtin_popcountll(possible);
    if (is_border) {
      bool has_hit = false;
      for (const SubPatch* span = &part; span != nullptr; span = next_beside(*span))
        has_hit |= ask_all(patches[span->patch], *span, possible);
      return has_hit;
    }
    if (is_left_to_solver(patch, part)) return ask_all(patch, part, possible);
    Candidates rays;
    gather(possible, rays);
    if (patch.is_rational) {
      if (patch.degree_u == 2 && patch.degree_v == 2) return decide<true, 2, 2>(patch, part, rays);
      if (patch.degree_u == 2 && patch.degree_v == 1) return decide<true, 2, 1>(patch, part, rays);
      return decide<true, 0, 0>(patch, part, rays);
    }
    if (patch.degree_u == 3 && patch.degree_v == 3) return decide<false, 3, 3>(patch, part, rays);
    if (patch.degree_u == 1 && patch.degree_v == 1) return decide<false, 1, 1>(patch, part, rays);
    return decide<false, 0, 0>(patch, part, rays);
  }
  for (size_t ray = 0; ray < kPacketRays; ++ray)
    if (rays_.best_t[ray] >= least_t(rays_, ray)) possible |= uint64_t{1} << ray;
  return possible != 0 && ask_all(patch, part, possible);
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::ask_all(const Patch& patch, const SubPatch& part,
                                                   uint64_t possible) {
  bool has_hit = false;
  if (!waiting_.has_room(__builtin_popcountll(possible))) has_hit = ask_waiting();
  do {
    const auto number = static_cast<size_t>(__builtin_ctzll(possible));
    PatchQuestion& question = waiting_.add(number);
    question.patch = &patch;
    question.part = &part;
    origin_of(rays_, number, question.origin);
    rays_.direction_of(number, question.direction);
    question.t_range[0] = least_t(rays_, number);
    question.t_range[1] = kAny ? rays_.best_t[number] : __builtin_inff();
    question.is_any = kAny;
    possible &= possible - 1;
  } while (possible != 0);
  return waiting_.count < kWorthAsking ? has_hit : has_hit | ask_waiting();
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::ask_waiting() {
  PatchAnswer answers[kPatchQuestionsMax];
  const uint64_t left = filtered_answers(waiting_.question, waiting_.count, answers);
  bool has_hit = false;
  if (!open_.has_room(__builtin_popcountll(left))) has_hit = ask_open();
  for (int k = 0; k < waiting_.count; ++k) {
    const PatchQuestion& question = waiting_.question[k];
    if ((left >> k & 1) != 0) {
      open_.add(waiting_.ray[k]) = question;
    } else if (answers[k].is_hit) {
      has_hit |= take(*question.part, waiting_.ray[k], answers[k].t);
    }
  }
  waiting_.count = 0;
  return open_.count < kOpenWorthAsking ? has_hit : has_hit | ask_open();
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::ask_open() {
  const int all = open_.count;
  open_.count = 0;
  for (int k = 0; k < all; ++k) {
    const size_t ray = open_.ray[k];
    // Rays that were blocked meanwhile look for nothing.
    const bool looks = !kAny || rays_.best_t[ray] >= least_t(rays_, ray);
    if (looks) open_.add(ray) = open_.question[k];
  }
  PatchAnswer answers[kPatchQuestionsMax];
  unfiltered_answers(open_.question, open_.count, answers);
  bool has_hit = false;
  for (int k = 0; k < open_.count; ++k)
    if (answers[k].is_hit) has_hit |= take(*open_.question[k].part, open_.ray[k], answers[k].t);
  open_.count = 0;
  return has_hit;
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
void PatchPacketTest<W, kAny, Rays, Test>::gather(uint64_t possible, Candidates& rays) const {
  for (; possible != 0; possible &= possible - 1) {
    const auto ray = static_cast<size_t>(__builtin_ctzll(possible));
    const int i = rays.count++;
    rays.ray[i] = static_cast<uint8_t>(ray);
    float origin[3], direction[3];
    origin_of(rays_, ray, origin);
    rays_.direction_of(ray, direction);
    for (int a = 0; a < 3; ++a) {
      rays.origin[a][i] = static_cast<double>(origin[a]);
      rays.direction[a][i] = static_cast<double>(direction[a]);
    }
  }
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < 8; ++i) {
      rays.origin[a][rays.count + i] = rays.origin[a][rays.count - 1];
      rays.direction[a][rays.count + i] = rays.direction[a][rays.count - 1];
    }
  }
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
template <bool kRational, int kM, int kN>
bool PatchPacketTest<W, kAny, Rays, Test>::decide(const Patch& patch, const SubPatch& part,
                                                  const Candidates& rays) {
  const PointsInFrame<kRational, kM, kN> local(part, patch);
  const PartNumbers<double> numbers = numbers_of(part, patch.extent);
  constexpr int kWidth = static_cast<int>(kLanesOf<Doubles>);
  bool has_hit = false;
  uint64_t asked = 0;
  for (int first = 0; first < rays.count; first += kWidth) {
    Doubles origin[3] = {}, direction[3] = {};
    for (int a = 0; a < 3; ++a) {
      origin[a] = load<Doubles>(rays.origin[a] + first);
      direction[a] = load<Doubles>(rays.direction[a] + first);
    }
    const PatchDecision<Doubles> answer = decided_of<Doubles, kRational, kM, kN>(
        numbers, local.points(), patch.degree_u, patch.degree_v, origin, direction);
    alignas(64) double t[kWidth], u[kWidth] = {}, v[kWidth] = {};
    store(answer.t, t);
    if (part.is_trimmed) {
      store(answer.u, u);
      store(answer.v, v);
    }
    const int count = rays.count - first;
    const uint32_t there = count < kWidth ? (1u << count) - 1 : ~0u;
    uint32_t hits = bits_of<Doubles>(answer.is_hit) & there;
    if (part.is_trimmed && hits != 0) hits = kept_of_hits(patch, u, v, hits);
    for (; hits != 0; hits &= hits - 1) {
      const int i = __builtin_ctz(hits);
      const auto ray = static_cast<size_t>(rays.ray[first + i]);
      if (t[i] >= static_cast<double>(least_t(rays_, ray)))
        has_hit |= take(part, ray, static_cast<float>(t[i]));
    }
    for (uint32_t open = bits_of<Doubles>(answer.is_undecided) & there; open != 0; open &= open - 1)
      asked |= uint64_t{1} << rays.ray[first + __builtin_ctz(open)];
  }
  if (asked != 0) has_hit |= ask_all(patch, part, asked);
  return has_hit;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
