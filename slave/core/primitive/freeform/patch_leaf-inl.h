// SPDX-License-Identifier: Apache-2.0
// Leaves with sub-patches, in world space: of one ray, which may be in flight, and of packets.
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
#include "slave/core/primitive/freeform/patch_packet-inl.h"
#include "slave/core/primitive/freeform/patch_pairs-inl.h"
#include "slave/core/primitive/mixed_leaf-inl.h"
#include "slave/core/primitive/patch/patch_decision-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What tests a sub-patch against one ray, in MixedRayLeaf.
template <int W, bool kAny>
class PatchRayTest {
 public:
  HWY_INLINE PatchRayTest(OneRay& ray, TriangleRay<W, kAny>&) : ray_(ray) {}

  HWY_INLINE void test(const TrianglesAndPatches<W>& shapes, uint32_t number) {
    if (may_meet(shapes.parts[number])) ask(shapes, number);
  }
  HWY_INLINE bool may_meet(const SubPatch& part) const {
    return (!part.has_frame || PatchRayFilter::is_possible(ray_, part)) &&
           !ray_.excludes(part.primitive);
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
    const float end = kAny ? ray_.best_t : __builtin_inff();
    PatchQuestion question{&patch, &part, {}, {}, {ray_.t_min, end}, kAny};
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
