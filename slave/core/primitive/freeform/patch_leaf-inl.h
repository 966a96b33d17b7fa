// SPDX-License-Identifier: Apache-2.0
// Leaves with sub-patches, in world space. Rays of a packet that may meet one (patch_filter-inl.h)
// are put side by side and decided a register at a time, by the operations of patch_hit(); what
// that leaves undecided goes to the complete solver, ray by ray.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/shapes_layout.h"

#if defined(TESSERA_CORE_PATCH_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_LEAF_INL_H_
#undef TESSERA_CORE_PATCH_LEAF_INL_H_
#else
#define TESSERA_CORE_PATCH_LEAF_INL_H_
#endif

#include "slave/core/primitive/freeform/patch_filter-inl.h"
#include "slave/core/primitive/freeform/patch_pairs-inl.h"
#include "slave/core/primitive/freeform/points_in_frame-inl.h"
#include "slave/core/primitive/mixed_leaf-inl.h"
#include "slave/core/primitive/patch/patch_decision-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What tests a sub-patch against the rays of a packet, in MixedPacketLeaf.
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
  // Asks the complete solver what waits to be asked. Returns: whether some ray has a new best hit.
  HWY_INLINE bool settle_waiting() { return waiting_count_ != 0 && ask_waiting(); }

 private:
  // Questions to the complete solver are put together: it keeps its lanes busy where there are
  // several times as many, and rays learn of hits the later the more there are.
  static constexpr int kWorthAsking = 24;

  // Rays that may meet a sub-patch, side by side; the last ones are repeated to fill a register.
  struct Candidates {
    int count = 0;
    uint8_t ray[kPacketRays];
    alignas(64) double origin[3][kPacketRays + 8], direction[3][kPacketRays + 8];
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
  HWY_INLINE bool take(const SubPatch& part, size_t ray, float t) {
    if (!kAny) test_.settle(ray);
    return rays_.template take<kAny>(ray, t, least_t(rays_, ray), part.primitive);
  }

  Rays& rays_;
  Test<W, kAny>& test_;
  FanRows rows_;
  int waiting_count_ = 0;
  uint8_t waiting_ray_[kPatchQuestionsMax];
  PatchQuestion waiting_[kPatchQuestionsMax];
};

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::test(const Patch* patches, const SubPatch& part) {
  const Patch& patch = patches[part.patch];
  uint64_t possible = 0;
  if (part.has_frame) {
    const Filter filter(rays_, part);
    uint64_t rows = FanRows::kAll;
    if constexpr (kAsksRows) rows = filter.possible_rows(rows_);
    if (rows == 0) return false;
    const bool is_border = is_border_span(part);
    possible = is_border                       ? possible_rays(filter, rows, BorderBend(part))
               : PatchHull::helps(patch, part) ? possible_rays(filter, rows, PatchHull(patch, part))
                                               : possible_rays(filter, rows, NothingMore());
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
  if (waiting_count_ + __builtin_popcountll(possible) > kPatchQuestionsMax) has_hit = ask_waiting();
  do {
    const auto number = static_cast<size_t>(__builtin_ctzll(possible));
    waiting_ray_[waiting_count_] = static_cast<uint8_t>(number);
    PatchQuestion& question = waiting_[waiting_count_++];
    question.patch = &patch;
    question.part = &part;
    origin_of(rays_, number, question.origin);
    rays_.direction_of(number, question.direction);
    question.t_range[0] = least_t(rays_, number);
    question.t_range[1] = __builtin_inff();
    possible &= possible - 1;
  } while (possible != 0);
  return waiting_count_ < kWorthAsking ? has_hit : has_hit | ask_waiting();
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketTest<W, kAny, Rays, Test>::ask_waiting() {
  PatchAnswer answers[kPatchQuestionsMax];
  solved_answers(waiting_, waiting_count_, answers);
  bool has_hit = false;
  for (int k = 0; k < waiting_count_; ++k)
    if (answers[k].is_hit) has_hit |= take(*waiting_[k].part, waiting_ray_[k], answers[k].t);
  waiting_count_ = 0;
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

// What tests a sub-patch against one ray, in MixedRayLeaf.
template <int W, bool kAny>
class PatchRayTest {
 public:
  HWY_INLINE PatchRayTest(OneRay& ray, TriangleRay<W, kAny>&) : ray_(ray) {}

  HWY_INLINE void test(const TrianglesAndPatches<W>& shapes, uint32_t number) {
    if (may_meet(shapes.parts[number])) ask(shapes, number);
  }
  HWY_INLINE bool may_meet(const SubPatch& part) const {
    return !part.has_frame || PatchRayFilter::is_possible(ray_, part);
  }
  HWY_NOINLINE void ask(const TrianglesAndPatches<W>& shapes, uint32_t number) {
    ask(shapes.patches, shapes.parts[number]);
  }
  // The same, wherever they are. patches: those that sub-patches name.
  HWY_INLINE void ask(const Patch* patches, const SubPatch& part) {
    ask_one(patches, part);
    if (!is_border_span(part)) return;
    for (const SubPatch* span = next_beside(part); span != nullptr; span = next_beside(*span))
      if (may_meet(*span)) ask_one(patches, *span);
  }
  // What is asked of the complete solver where the decision leaves it undecided.
  HWY_INLINE PatchQuestion question(const Patch& patch, const SubPatch& part) const {
    PatchQuestion question{&patch, &part, {}, {}, {ray_.t_min, __builtin_inff()}};
    for (int a = 0; a < 3; ++a) {
      question.origin[a] = ray_.origin[a];
      question.direction[a] = ray_.direction[a];
    }
    return question;
  }
  HWY_INLINE void take(const SubPatch& part, const PatchAnswer& answer) {
    const auto number = static_cast<int32_t>(part.primitive);
    if (answer.is_hit && ray_.is_nearer(answer.t, number))
      ray_.template accept<kAny>(answer.t, number);
  }
  HWY_INLINE const OneRay& ray() const { return ray_; }

  int waiting = 0;  // answers that are not known yet

 private:
  HWY_INLINE void ask_one(const Patch* patches, const SubPatch& part) {
    take(part, patch_answer(patches[part.patch], part, ray_.origin, ray_.direction, ray_.t_min));
  }

  OneRay& ray_;
};

// Leaf test of one ray, which may be in flight.
template <int W, bool kAny>
class PatchRayLeaf : public MixedRayLeaf<TrianglesAndPatches<W>, W, kAny, PatchRayTest<W, kAny>> {
  using Shapes = TrianglesAndPatches<W>;
  using Test = PatchRayTest<W, kAny>;
  using Base = MixedRayLeaf<Shapes, W, kAny, Test>;

 public:
  static constexpr bool kSettlesAtOnce = false;

  struct Found {
    Candidates triangles;
    bool is_part;  // one that the ray may meet
  };

  using Base::Base;

  // What test() does for one block, in two steps, between which other rays have theirs.
  HWY_INLINE Found look(const Shapes& shapes, uint32_t block) const {
    const uint32_t item = shapes.blocks[block];
    if ((item & kIsItem) == 0) return {this->test_.look(shapes.triangles[item]), false};
    return {{0, 0, 0}, this->item_.may_meet(shapes.parts[item ^ kIsItem])};
  }
  static HWY_INLINE bool may_hit(const Found& found) {
    return found.is_part || found.triangles.possible != 0;
  }

  // The second steps of rays in flight. Answers of sub-patches wait until a register is full, and
  // those of the complete solver until it has several. Of a ray of which any hit will do, nothing
  // more is asked once it has one.
  class Settling {
   public:
    explicit Settling(const Shapes& shapes) : shapes_(shapes) {}

    HWY_INLINE void settle(PatchRayLeaf& leaf, uint32_t block, const Found& found) {
      const uint32_t item = shapes_.blocks[block];
      if (!found.is_part) return leaf.test_.settle(shapes_.triangles[item], found.triangles);
      const SubPatch& part = shapes_.parts[item ^ kIsItem];
      const Patch& patch = shapes_.patches[part.patch];
      if (kAny && leaf.item_.ray().has_hit()) return;
      if (PatchPairs::is_to_be_solved(patch, part)) {
        put_question(leaf.item_, patch, part);
        if (asked_count_ >= kWorthAsking) ask();
        return;
      }
      if (!PatchPairs::takes(patch, part)) return leaf.item_.ask(shapes_, item ^ kIsItem);
      pairs_.put(count_, leaf.item_.ray(), patch, part);
      ++leaf.item_.waiting;
      test_[count_] = &leaf.item_;
      part_[count_++] = &part;
      if (count_ == PatchPairs::kWidth) decide();
    }
    // Whether no answer of the leaf's ray waits.
    HWY_INLINE bool is_settled(const PatchRayLeaf& leaf) const { return leaf.item_.waiting == 0; }
    // Settles all that wait.
    HWY_INLINE void finish() {
      if (count_ > 0) decide();
      if (asked_count_ > 0) ask();
    }

   private:
    static constexpr int kWorthAsking = 16;

    HWY_INLINE void put_question(Test& test, const Patch& patch, const SubPatch& part) {
      ++test.waiting;
      asked_[asked_count_] = &test;
      questions_[asked_count_++] = test.question(patch, part);
    }
    HWY_NOINLINE void decide();
    HWY_NOINLINE void ask();

    const Shapes& shapes_;
    int count_ = 0;
    Test* test_[PatchPairs::kWidth];
    const SubPatch* part_[PatchPairs::kWidth];
    PatchPairs pairs_;
    int asked_count_ = 0;
    Test* asked_[kWorthAsking + PatchPairs::kWidth];
    PatchQuestion questions_[kWorthAsking + PatchPairs::kWidth];
  };
};

template <int W, bool kAny>
void PatchRayLeaf<W, kAny>::Settling::decide() {
  pairs_.fill(count_);
  const PatchDecision<Doubles> answer = pairs_.decide();
  alignas(64) double t[PatchPairs::kWidth], u[PatchPairs::kWidth], v[PatchPairs::kWidth];
  store(answer.t, t);
  store(answer.u, u);
  store(answer.v, v);
  const uint32_t there = (1u << count_) - 1;
  for (int i = 0; i < count_; ++i) --test_[i]->waiting;
  count_ = 0;
  for (uint32_t hits = bits_of<Doubles>(answer.is_hit) & there; hits != 0; hits &= hits - 1) {
    const int i = __builtin_ctz(hits);
    if (!(t[i] >= static_cast<double>(test_[i]->ray().t_min))) continue;
    if (part_[i]->is_trimmed && !is_kept(shapes_.patches[part_[i]->patch], u[i], v[i])) continue;
    test_[i]->take(*part_[i], {true, static_cast<float>(t[i]), u[i], v[i]});
  }
  for (uint32_t open = bits_of<Doubles>(answer.is_undecided) & there; open != 0; open &= open - 1) {
    const int i = __builtin_ctz(open);
    if (kAny && test_[i]->ray().has_hit()) continue;
    put_question(*test_[i], shapes_.patches[part_[i]->patch], *part_[i]);
  }
  if (asked_count_ >= kWorthAsking) ask();
}

template <int W, bool kAny>
void PatchRayLeaf<W, kAny>::Settling::ask() {
  PatchAnswer answers[kWorthAsking + PatchPairs::kWidth];
  solved_answers(questions_, asked_count_, answers);
  for (int k = 0; k < asked_count_; ++k) {
    --asked_[k]->waiting;
    asked_[k]->take(*questions_[k].part, answers[k]);
  }
  asked_count_ = 0;
}

template <int W>
struct LeafTests<TrianglesAndPatches<W>> {
  using Shapes = TrianglesAndPatches<W>;
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const Shapes& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
  template <bool kAny>
  using Ray = PatchRayLeaf<W, kAny>;
  template <bool kAny>
  using Fan = MixedPacketLeaf<Shapes, W, kAny, FanRays, FanBlock,
                              PatchPacketTest<W, kAny, FanRays, FanBlock>>;
  template <bool kAny>
  using Bundle = MixedPacketLeaf<Shapes, W, kAny, BundleRays, BundleBlock,
                                 PatchPacketTest<W, kAny, BundleRays, BundleBlock>>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
