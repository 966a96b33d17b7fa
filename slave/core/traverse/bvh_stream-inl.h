// SPDX-License-Identifier: Apache-2.0
// Traversal by rays with origins and directions of their own, 64 at a time, of a hierarchy whose
// leaves lead into other structures, as instances do. It is small, and what its leaves lead to
// takes long; so the rays go through it together, without a look at what they hit: first each ray
// finds all leaves that it meets, node by node of all rays, in loops in which hardly a branch
// depends on a ray; then the rays take their leaves, each the nearest first, in rounds, in which
// all of them step into a structure and go through it. Decision: ../decisions/instances.md.
//
// A ray's answer is that of bvh_ray-inl.h: both visit every leaf that the ray meets before its hit,
// or, where any hit will do, until it has one. A ray that meets too many leaves is traced by
// itself, and so are those that are not done with the nodes when there are too many, and those that
// begin behind their origin.
//
// Threads. One traversal owns one.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_BVH_STREAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_STREAM_INL_H_
#undef TESSERA_CORE_BVH_STREAM_INL_H_
#else
#define TESSERA_CORE_BVH_STREAM_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/traverse/many_rays-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Whether rays stream through a structure. That takes nodes as wide as a register, an instruction
// set that compresses registers of 16, and leaves with
//   bool leads_on(shapes, block)          whether the block leads into another structure;
//   void join(stream, shapes, block)      adds the ray to those that are taken there;
//   Stream, with clear(), and run(), which takes them there and comes back.
template <class View, class Leaf>
constexpr bool kStreams = false;

#if HWY_TARGET == HWY_AVX3

template <class Shapes, class Leaf>
constexpr bool kStreams<BvhView<16, Shapes>, Leaf> = requires {
  typename Leaf::Stream;
};

// The leaves that a ray meets, and where it does.
class MetLeaves {
  using V = FloatsOf<16>;

 public:
  static constexpr size_t kMost = 32;

  void clear() { size_ = 0; }
  bool is_empty() const { return size_ == 0; }
  // Whether the leaves of any node fit.
  HWY_INLINE bool has_room() const { return size_ + 16 <= kMost; }
  // Requires: has_room().
  HWY_INLINE void add(UintOf<V> child, V distance, uint32_t met) {
    store_packed(child, mask_of<UintOf<V>>(met), child_ + size_);
    store_packed(distance, mask_of<V>(met), distance_ + size_);
    size_ += static_cast<size_t>(__builtin_popcount(met));
  }
  // To be called before pop_nearest().
  HWY_INLINE void sort() {
    if (HWY_LIKELY(size_ <= 8)) return sort_few();
    for (size_t i = 0; i < size_; ++i) {
      const StackEntry next{child_[i], distance_[i]};
      size_t at = i;
      for (; at > 0 && entry_[at - 1].distance < next.distance; --at) entry_[at] = entry_[at - 1];
      entry_[at] = next;
    }
  }
  // Requires: it is not empty.
  HWY_INLINE StackEntry pop_nearest() { return entry_[--size_]; }
  // Adds the leaf or does not, without a branch.
  HWY_INLINE void push_if(bool is_wanted, StackEntry leaf) {
    entry_[size_] = leaf;
    size_ += is_wanted;
  }

 private:
  HWY_INLINE void sort_few() {
    const ChildKeys::Tag keys;
    const ChildKeys::HalfTag halves;
    const auto distance = hn::Load(halves, reinterpret_cast<const uint32_t*>(distance_));
    const auto met = ChildKeys::of(distance, hn::Load(halves, child_));
    const auto wanted = hn::IfThenElseZero(hn::FirstN(keys, size_), met);
    hn::StoreU(ChildKeys::sorted8(wanted), keys, reinterpret_cast<uint64_t*>(entry_));
  }

  alignas(64) uint32_t child_[kMost + 16];
  alignas(64) float distance_[kMost + 16];
  alignas(64) StackEntry entry_[kMost + 1];  // the nearest last
  size_t size_;
};

template <class View, class Leaf>
class BvhStream {
  static constexpr int W = View::kWidth;
  static constexpr int kSlots = 64;
  static constexpr size_t kNodesMost = 16 * kSlots;  // that are visited by all rays

 public:
  // Requires: the scene outlives it. Some 100 KB.
  explicit BvhStream(const View& scene) : scene_(scene) {}

  // Rays: as in BvhFlight.
  template <class Rays>
  void run(Rays& rays);

 private:
  struct Slot {
    OneRay ray;
    RaySlabs<W> slabs;
    Leaf leaf{ray};
    MetLeaves leaves;
    SingleRay given;
    int number;
    bool is_lost;    // the ray meets too much, or begins behind its origin
    uint32_t block;  // that the ray has come to
  };
  using Group = SlotGroup<View, Slot>;
  using Slots = SlotList<kSlots>;
  // Which rays do what in a round.
  struct Round {
    Slots at_test, at_way_in, next;
  };

  template <class Rays>
  HWY_INLINE bool set_up(Rays& rays);
  template <class Rays>
  HWY_INLINE void set_up(int first, Rays& rays);
  template <class Rays>
  HWY_INLINE void end(const Slot& slot, Rays& rays);
  HWY_INLINE void visit(uint8_t s, const BvhNode<W>& node);
  HWY_INLINE void find_leaves();
  HWY_INLINE void test_leaves();
  HWY_INLINE void take_next(const Slots& waiting, Round& round);

  const View& scene_;
  Slot slots_[kSlots];
  int slot_count_ = 0;
  // The nodes to visit and by which ray: all that were found so far.
  alignas(64) uint32_t node_[kNodesMost + 16];
  alignas(64) uint32_t visitor_[kNodesMost + 16];
  size_t node_count_ = 0;
  typename Leaf::Stream stream_;
};

// Takes as many rays as there is room for. Returns: whether there may be more.
template <class View, class Leaf>
template <class Rays>
bool BvhStream<View, Leaf>::set_up(Rays& rays) {
  slot_count_ = 0;
  while (slot_count_ < kSlots) {
    Slot& slot = slots_[slot_count_];
    slot.number = rays.next(slot.given);
    if (slot.number < 0) break;
    ++slot_count_;
  }
  const bool is_full = slot_count_ == kSlots;
  // Rays that are not valid leave.
  for (int first = 0; first < slot_count_; first += Group::kMost) set_up(first, rays);
  return is_full;
}

// Sets up a group of rays, from `first` on. Of those that are not valid the last one takes the
// place.
template <class View, class Leaf>
template <class Rays>
void BvhStream<View, Leaf>::set_up(int first, Rays& rays) {
  Group group;
  for (int s = first; s < min_of(first + Group::kMost, slot_count_); ++s) group.add(slots_[s]);
  const bool are_valid = group.set_up(scene_);
  for (int s = first; s < min_of(first + Group::kMost, slot_count_); ++s) {
    while (HWY_UNLIKELY(!are_valid) && !Group::set_up_alone(scene_, slots_[s])) {
      rays.ended(slots_[s].number, SingleHit{0, kNoPrimitive});
      const Slot& last = slots_[--slot_count_];
      if (s == slot_count_) return;
      slots_[s].given = last.given;
      slots_[s].number = last.number;
    }
    slots_[s].leaf.prepare();
    slots_[s].leaves.clear();
    // Leaves are sorted by the bits of their distances, which must not be negative.
    slots_[s].is_lost = __builtin_signbitf(slots_[s].ray.near_limit) != 0;
    TESSERA_COUNT(singles, 1);
  }
}

template <class View, class Leaf>
void BvhStream<View, Leaf>::visit(uint8_t s, const BvhNode<W>& node) {
  using V = FloatsOf<16>;
  Slot& slot = slots_[s];
  alignas(64) float t_in[W];
  const uint32_t met = slot.slabs.overlapping(slot.ray, node, t_in);
  const auto child = load<UintOf<V>>(node.child);
  const uint32_t leaves = met & bits_of<IntOf<V>>(bit_cast<IntOf<V>>(child) < 0);
  const uint32_t inner = met & ~leaves;
  store_packed(child, mask_of<UintOf<V>>(inner), node_ + node_count_);
  store_unaligned(set<UintOf<V>>(s), visitor_ + node_count_);
  node_count_ += static_cast<size_t>(__builtin_popcount(inner));
  slot.leaves.add(child, load<V>(t_in), leaves);
}

template <class View, class Leaf>
void BvhStream<View, Leaf>::find_leaves() {
  node_count_ = static_cast<size_t>(slot_count_);  // the root
  for (uint8_t s = 0; s < slot_count_; ++s) {
    node_[s] = 0;
    visitor_[s] = s;
  }
  for (size_t i = 0; i < node_count_; ++i) {
    const auto s = static_cast<uint8_t>(visitor_[i]);
    if (HWY_UNLIKELY(!slots_[s].leaves.has_room())) {
      slots_[s].is_lost = true;
    } else if (HWY_UNLIKELY(node_count_ > kNodesMost)) {
      for (; i < node_count_; ++i) slots_[visitor_[i]].is_lost = true;
    } else {
      visit(s, scene_.nodes[node_[i]]);
    }
  }
}

// Takes the next block of each waiting ray.
template <class View, class Leaf>
void BvhStream<View, Leaf>::take_next(const Slots& waiting, Round& round) {
  for (int i = 0; i < waiting.count; ++i) {
    const uint8_t s = waiting.slot[i];
    Slot& slot = slots_[s];
    const StackEntry entry = slot.leaves.pop_nearest();
    const bool is_near = entry.distance <= slot.ray.far_limit;  // else none of the others is
    slot.block = leaf_first(entry.child);
    slot.leaves.push_if(is_near & (leaf_count(entry.child) > 1),
                        {entry.child + 1 - (1u << kBvhCountShift), entry.distance});
    const bool leads_on = Leaf::leads_on(scene_.shapes, slot.block);
    round.at_way_in.add_if(is_near & leads_on, s);
    round.at_test.add_if(is_near & !leads_on, s);
    round.next.add_if(is_near & !slot.leaves.is_empty(), s);
  }
}

template <class View, class Leaf>
void BvhStream<View, Leaf>::test_leaves() {
  Slots waiting;
  for (uint8_t s = 0; s < slot_count_; ++s) {
    slots_[s].leaves.sort();
    waiting.add_if(!slots_[s].is_lost & !slots_[s].leaves.is_empty(), s);
  }
  while (waiting.count > 0) {
    Round round;
    take_next(waiting, round);
    for (int i = 0; i < round.at_test.count; ++i) {
      Slot& slot = slots_[round.at_test.slot[i]];
      slot.leaf.test(scene_.shapes, slot.block, 1);
    }
    stream_.clear();
    for (int i = 0; i < round.at_way_in.count; ++i) {
      Slot& slot = slots_[round.at_way_in.slot[i]];
      slot.leaf.join(stream_, scene_.shapes, slot.block);
    }
    stream_.run();
    waiting = round.next;
  }
}

template <class View, class Leaf>
template <class Rays>
void BvhStream<View, Leaf>::end(const Slot& slot, Rays& rays) {
  if (HWY_UNLIKELY(slot.is_lost)) return rays.ended(slot.number, rays.alone(slot.given));
  const bool has_hit = slot.ray.has_hit();  // -1 is kNoPrimitive
  rays.ended(slot.number,
             SingleHit{has_hit ? slot.ray.best_t : 0, static_cast<uint32_t>(slot.ray.best)});
}

template <class View, class Leaf>
template <class Rays>
void BvhStream<View, Leaf>::run(Rays& rays) {
  bool has_more = true;
  while (has_more) {
    has_more = set_up(rays);
    find_leaves();
    test_leaves();
    for (int s = 0; s < slot_count_; ++s) end(slots_[s], rays);
  }
}

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
