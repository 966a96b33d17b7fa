// SPDX-License-Identifier: Apache-2.0
// Traversal of a wide hierarchy by many rays that have nothing in common: 32 rays are in flight,
// and each round takes every one of them a step further, first those that stand at a node, then
// those that stand at a leaf, then those with primitives that need a closer look. A ray by itself
// waits for each step's result, since the next step is a branch on it; here the steps of different
// rays overlap, and hardly a branch depends on a ray. Rays are set up a group at a time, before
// they take off. Decision: ../decisions/flights.md.
//
// Where any hit will do and leaves settle at once, a ray is first tested against the block that
// blocked a ray last: of those that the same block blocks, few take off. Where answers of leaves
// wait, a ray goes on meanwhile, and ends in the first round in which it is known to be blocked.
//
// A ray's answer is that of bvh_ray-inl.h: both visit every box that the ray meets before its hit,
// in another order. A ray that has too many boxes to come back to is traced by itself.
//
// Threads. One traversal owns one.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_BVH_FLIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_FLIGHT_INL_H_
#undef TESSERA_CORE_BVH_FLIGHT_INL_H_
#else
#define TESSERA_CORE_BVH_FLIGHT_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/traverse/many_rays-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class View, class Leaf>
class BvhFlight;

// Whether rays fly through a structure. That takes a leaf test in two steps, nodes as wide as a
// register, and an instruction set that compresses and permutes registers of 16.
template <class View, class Leaf>
constexpr bool kFlies = false;

#if HWY_TARGET == HWY_AVX3

template <class Shapes, class Leaf>
constexpr bool kFlies<BvhView<16, Shapes>, Leaf> = requires {
  typename Leaf::Found;
};

// Boxes that a ray still has to visit, the nearest on top.
class FlightStack {
 public:
  // Entries. Rays of ordinary scenes have up to some 30 at a time; 64 keep a flight in the first
  // cache.
  static constexpr int kMost = 64;

  // The root, and below it what ends a ray.
  HWY_INLINE void begin() {
    entries_[0] = {kBvhNoChild, -__builtin_inff()};
    entries_[1] = {0, -__builtin_inff()};
    size_ = 2;
  }
  HWY_INLINE StackEntry pop() { return entries_[--size_]; }
  // Leaves nothing but what ends a ray.
  HWY_INLINE void end() { size_ = 1; }
  // Adds the entry or does not, without a branch.
  HWY_INLINE void push_if(bool is_wanted, StackEntry entry) {
    entries_[size_] = entry;
    size_ += is_wanted;
  }
  // Whether the children of any node fit, and a leaf's next block; registers are stored whole.
  HWY_INLINE bool has_room() const { return size_ + 16 + 1 <= kMost; }

  // Adds the children `met` of a node, sorted by distance.
  HWY_INLINE void push(const BvhNode<16>& node, uint32_t met, const float* distance) {
    const hn::CappedTag<float, 16> d;
    const hn::CappedTag<uint32_t, 16> du;
    const ChildKeys::Tag keys;
    const ChildKeys::HalfTag halves;
    const auto far = hn::BitCast(du, hn::Compress(hn::Load(d, distance), mask_of(d, met)));
    const auto child = hn::Compress(hn::Load(du, node.child), mask_of(du, met));
    const auto count = static_cast<size_t>(__builtin_popcount(met));
    const auto low =
        hn::IfThenElseZero(hn::FirstN(keys, count),
                           ChildKeys::of(hn::LowerHalf(halves, far), hn::LowerHalf(halves, child)));
    uint64_t* const to = reinterpret_cast<uint64_t*>(entries_ + size_);
    if (HWY_UNLIKELY(count > 8)) {
      // In two halves: the farther children of each are below.
      const auto high = hn::IfThenElseZero(
          hn::FirstN(keys, count - 8),
          ChildKeys::of(hn::UpperHalf(halves, far), hn::UpperHalf(halves, child)));
      hn::StoreU(ChildKeys::sorted8(high), keys, to);
      hn::StoreU(ChildKeys::sorted8(low), keys, to + (count - 8));
    } else {
      hn::StoreU(count > 4 ? ChildKeys::sorted8(low) : ChildKeys::sorted4(low), keys, to);
    }
    size_ += static_cast<int>(count);
  }

  // The same in any order, for rays of which any hit will do.
  HWY_INLINE void push_unsorted(const BvhNode<16>& node, uint32_t met) {
    const hn::CappedTag<uint32_t, 16> du;
    const ChildKeys::Tag keys;
    const ChildKeys::HalfTag halves;
    const auto child = hn::Compress(hn::Load(du, node.child), mask_of(du, met));
    const auto near = hn::Set(halves, 0xff800000u);  // -inf
    uint64_t* const to = reinterpret_cast<uint64_t*>(entries_ + size_);
    hn::StoreU(ChildKeys::of(near, hn::LowerHalf(halves, child)), keys, to);
    hn::StoreU(ChildKeys::of(near, hn::UpperHalf(halves, child)), keys, to + 8);
    size_ += __builtin_popcount(met);
  }

 private:
  alignas(64) StackEntry entries_[kMost];
  int size_ = 0;
};

template <class View, class Leaf>
class BvhFlight {
  static constexpr int W = View::kWidth;
  static constexpr bool kAny = Leaf::kIsAny;
  // Whether a ray may turn out to be blocked after it has left the leaf.
  static constexpr bool kIsBlockedLate = kAny && !Leaf::kSettlesAtOnce;
  static constexpr int kFlying = 32;
  // Of rays that still have boxes to visit: while there are as many, a ray whose answers are not
  // all known waits at its end.
  static constexpr int kWorthWaiting = 12;

 public:
  // Requires: the scene outlives it. Some 30 KB, most of which are the rays' stacks.
  explicit BvhFlight(const View& scene);

  // rays.next(ray) fills in a ray and returns its number, or -1 when there are no more;
  // rays.ended(number, hit) takes its answer; rays.alone(ray) answers a ray by itself.
  template <class Rays>
  void run(Rays& rays);

 private:
  struct Slot {
    OneRay ray;
    RaySlabs<W> slabs;
    Leaf leaf{ray};
    SingleRay given;
    uint32_t child;
    int number;
    typename Leaf::Found found;
    FlightStack stack;
  };

  using Group = SlotGroup<View, Slot>;
  static constexpr int kSlots = kFlying + Group::kMost;
  using Slots = SlotList<kSlots>;
  // Which rays do what in a round.
  struct Round {
    const Slots& waiting;
    Slots at_node, at_leaf, ended, next;
  };

  HWY_INLINE void sort_out(Round& round);
  template <class Rays>
  HWY_INLINE void step_nodes(Round& round, Rays& rays, typename Leaf::Settling& settling);
  template <class Settling>
  HWY_INLINE void test_leaves(Round& round, Settling& settling);
  template <class Rays>
  HWY_INLINE void replace(uint8_t s, Rays& rays, Slots& next);
  template <class Rays>
  HWY_INLINE int take_off(Rays& rays);
  template <class Rays>
  HWY_NOINLINE bool set_up(Rays& rays);

  const View& scene_;
  Slot slots_[kSlots];
  Slots free_, ready_;           // slots whose rays do not fly
  uint32_t blocker_ = kNoBlock;  // of the ray that was blocked last
};

template <class View, class Leaf>
BvhFlight<View, Leaf>::BvhFlight(const View& scene) : scene_(scene) {
  for (uint8_t s = 0; s < kSlots; ++s) free_.add_if(true, s);
}

// Makes a group of rays ready. Rays that are not valid have ended. Requires: there are as many free
// slots. Returns: whether there was a ray.
template <class View, class Leaf>
template <class Rays>
bool BvhFlight<View, Leaf>::set_up(Rays& rays) {
  Group group;
  while (group.count() < Group::kMost) {
    Slot& slot = slots_[free_.slot[free_.count - 1]];
    slot.number = rays.next(slot.given);
    if (slot.number < 0) break;
    --free_.count;
    group.add(slot);
  }
  if (group.count() == 0) return false;
  const bool are_valid = group.set_up(scene_);
  for (int i = 0; i < group.count(); ++i) {
    Slot& slot = group[i];
    const auto s = static_cast<uint8_t>(&slot - slots_);
    if (HWY_LIKELY(are_valid) || Group::set_up_alone(scene_, slot)) {
      slot.leaf.prepare();
      slot.stack.begin();
      ready_.add_if(true, s);
    } else {
      rays.ended(slot.number, SingleHit{0, kNoPrimitive});
      free_.add_if(true, s);
    }
  }
  return true;
}

// Returns: the slot of a ray that is to fly, -1 without any.
template <class View, class Leaf>
template <class Rays>
int BvhFlight<View, Leaf>::take_off(Rays& rays) {
  for (;;) {
    while (ready_.count == 0) {
      if (!set_up(rays)) return -1;
    }
    const uint8_t s = ready_.slot[--ready_.count];
    Slot& slot = slots_[s];
    TESSERA_COUNT(singles, 1);
    if (!kAny || blocker_ == kNoBlock || slot.leaf.test(scene_.shapes, blocker_, 1) == kNoBlock)
      return s;
    rays.ended(slot.number, SingleHit{0, static_cast<uint32_t>(slot.ray.best)});
    free_.add_if(true, s);
  }
}

// Lets another ray fly, if there is one, in place of one that has ended.
template <class View, class Leaf>
template <class Rays>
void BvhFlight<View, Leaf>::replace(uint8_t s, Rays& rays, Slots& next) {
  free_.add_if(true, s);
  const int other = take_off(rays);
  next.add_if(other >= 0, static_cast<uint8_t>(other));
}

// Takes the next box of each waiting ray from its stack. Boxes behind what the ray has hit are
// passed over, one a round.
template <class View, class Leaf>
void BvhFlight<View, Leaf>::sort_out(Round& round) {
  for (int i = 0; i < round.waiting.count; ++i) {
    const uint8_t s = round.waiting.slot[i];
    Slot& slot = slots_[s];
    const StackEntry entry = slot.stack.pop();
    slot.child = entry.child;
    const bool is_blocked = kIsBlockedLate && slot.ray.has_hit();
    const bool is_end = is_blocked | (entry.child == kBvhNoChild);
    const bool is_leaf = (entry.child & kBvhLeaf) != 0;
    const bool is_near = entry.distance <= slot.ray.far_limit;
    round.at_node.add_if(is_near & !is_leaf & !is_blocked, s);
    round.at_leaf.add_if(is_near & is_leaf & !is_end, s);
    round.next.add_if(!is_near & !is_end, s);
    round.ended.add_if(is_end, s);
  }
}

template <class View, class Leaf>
template <class Rays>
void BvhFlight<View, Leaf>::step_nodes(Round& round, Rays& rays,
                                       typename Leaf::Settling& settling) {
  for (int i = 0; i < round.at_node.count; ++i) {
    const uint8_t s = round.at_node.slot[i];
    Slot& slot = slots_[s];
    alignas(64) float t_in[W];
    const BvhNode<W>& node = scene_.nodes[slot.child];
    const uint32_t met = slot.slabs.overlapping(slot.ray, node, t_in);
    if constexpr (kAny) {
      slot.stack.push_unsorted(node, met);
    } else {
      slot.stack.push(node, met, t_in);
    }
    const bool goes_on = slot.stack.has_room();
    round.next.add_if(goes_on, s);
    if (HWY_UNLIKELY(!goes_on)) {
      if (!settling.is_settled(slot.leaf)) settling.finish();
      rays.ended(slot.number, rays.alone(slot.given));
      replace(s, rays, round.next);
    }
  }
}

// Tests a block for each ray that stands at a leaf, first all of them in lanes, then those that may
// hit something, primitive by primitive. The leaf's other blocks come in the next rounds.
template <class View, class Leaf>
template <class Settling>
void BvhFlight<View, Leaf>::test_leaves(Round& round, Settling& settling) {
  Slots close;
  for (int i = 0; i < round.at_leaf.count; ++i) {
    const uint8_t s = round.at_leaf.slot[i];
    Slot& slot = slots_[s];
    slot.found = slot.leaf.look(scene_.shapes, slot.child & kBvhBlockMask);
    close.add_if(Leaf::may_hit(slot.found), s);
    slot.stack.push_if(leaf_count(slot.child) > 1,
                       {slot.child + 1 - (1u << kBvhCountShift), -__builtin_inff()});
    round.next.add_if(true, s);
  }
  for (int i = 0; i < close.count; ++i) {
    Slot& slot = slots_[close.slot[i]];
    settling.settle(slot.leaf, slot.child & kBvhBlockMask, slot.found);
    if (kAny && !kIsBlockedLate && slot.ray.has_hit()) {
      blocker_ = slot.child & kBvhBlockMask;
      slot.stack.end();
    }
  }
}

template <class View, class Leaf>
template <class Rays>
void BvhFlight<View, Leaf>::run(Rays& rays) {
  Slots waiting;
  typename Leaf::Settling settling(scene_.shapes);
  for (int s; waiting.count < kFlying && (s = take_off(rays)) >= 0;)
    waiting.add_if(true, static_cast<uint8_t>(s));
  while (waiting.count > 0) {
    Round round{waiting, {}, {}, {}, {}};
    sort_out(round);
    step_nodes(round, rays, settling);
    test_leaves(round, settling);
    for (int i = 0; i < round.ended.count; ++i) {
      const uint8_t s = round.ended.slot[i];
      if (!settling.is_settled(slots_[s].leaf)) {
        if (round.at_node.count + round.at_leaf.count >= kWorthWaiting) {
          slots_[s].stack.end();
          round.next.add_if(true, s);
          continue;
        }
        settling.finish();
      }
      const OneRay& ray = slots_[s].ray;
      const bool has_hit = ray.has_hit();  // -1 is kNoPrimitive
      rays.ended(slots_[s].number,
                 SingleHit{has_hit ? ray.best_t : 0, static_cast<uint32_t>(ray.best)});
      replace(s, rays, round.next);
    }
    waiting = round.next;
  }
}

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
