// SPDX-License-Identifier: Apache-2.0
// Rays that step into instances and go through the meshes together (bvh_stream-inl.h): four at a
// time are taken into object space; then come all nodes of all rays, all leaves, and all triangles
// that may be hit. In none of these loops is there a branch that depends on a ray. A ray meets few
// leaves of a mesh, so what is looked at behind its hit costs less than putting leaves in order.
//
// A ray's answer is that of instance_ray-inl.h: both test every triangle that the ray may hit
// before what it hits, and a triangle that is tested twice is no nearer the second time.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/instance_layout.h"

#if defined(TESSERA_CORE_INSTANCE_STREAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_INSTANCE_STREAM_INL_H_
#undef TESSERA_CORE_INSTANCE_STREAM_INL_H_
#else
#define TESSERA_CORE_INSTANCE_STREAM_INL_H_
#endif

#include "slave/core/primitive/instance/instance_ray-inl.h"
#include "slave/core/primitive/triangle/triangle_pairs-inl.h"
#include "slave/core/ray/axes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3

// Nodes or leaves that rays have to visit, by number, and the rays.
template <size_t kMost>
struct Visits {
  // The children of a node, all of which are added at once, may go beyond the most.
  static constexpr size_t kRoom = kMost + 16;

  alignas(64) uint32_t child[kRoom];
  alignas(64) uint32_t ray[kRoom];

  // Returns: how many there are when `children` (bits) have been added to `count`.
  template <class VU>
  HWY_INLINE size_t added(size_t count, VU of_node, uint32_t children, uint32_t number) {
    store_packed(of_node, mask_of<VU>(children), child + count);
    store_unaligned(set<VU>(number), ray + count);
    return count + static_cast<size_t>(__builtin_popcount(children));
  }
};

template <int W, bool kAny>
class InstanceStream {
  using V = FloatsOf<W>;
  using Shapes = TrianglesAndInstances<W>;
  using Test = InstanceRayTest<W, kAny>;
  using Inside = RayInside<W, kAny>;
  using Group = Axes<FloatsOf<16>>;

 public:
  static constexpr size_t kMost = 64;

  void clear() { count_ = 0; }
  // Requires: fewer than kMost rays are in it. test: of the ray.
  HWY_INLINE void add(Test& test, const Shapes& shapes, uint32_t instance) {
    tests_[count_] = &test;
    count_ += test.find(shapes, instance, inside_[count_]);
  }
  // Tests what was added.
  void run();

 private:
  static constexpr size_t kVisitsMost = 16 * kMost, kFoundMost = 4 * kMost;
  struct Found {
    const TriangleBlock<W>* block;
    uint32_t ray;
    Candidates triangles;
  };
  struct Counts {
    size_t nodes, leaves;
  };

  HWY_INLINE Counts enter(size_t first, Counts counts);
  HWY_INLINE Counts visit(uint32_t ray, const BvhNode<W>& node, Counts counts);
  HWY_INLINE Counts visit_nodes(Counts counts);
  HWY_INLINE void look_at(size_t leaves);
  HWY_NOINLINE void settle_found();
  HWY_INLINE void settle(const Found& found);

  size_t count_ = 0, found_count_ = 0;
  Test* tests_[kMost + 1];
  Inside inside_[kMost + 1];
  Visits<kVisitsMost> nodes_, leaves_;
  Found found_[kFoundMost];
  TrianglePairs<kAny> pairs_;
};

// Takes a group of rays, from `first` on, into their instances, and to the roots there.
template <int W, bool kAny>
typename InstanceStream<W, kAny>::Counts InstanceStream<W, kAny>::enter(size_t first,
                                                                        Counts counts) {
  const size_t last = min_of(first + Group::kRays, count_) - 1;
  Inside* inside[Group::kRays];  // a group that is not full has its last ray again
  const OneRay* outer[Group::kRays];
  const InstanceBlock* instance[Group::kRays];
  const SceneBox* mesh[Group::kRays];
  for (size_t r = 0; r < Group::kRays; ++r) {
    inside[r] = inside_ + min_of(first + r, last);
    outer[r] = &tests_[min_of(first + r, last)]->ray();
    instance[r] = inside[r]->instance;
    mesh[r] = &inside[r]->mesh->box;
  }
  const auto ray = [&](size_t r) HWY_ATTR { return &inside[r]->ray; };
  const auto box = [&](size_t r) HWY_ATTR { return mesh[r]; };
  const bool is_in = ObjectRay::enter_each<Group>(
      ray, [&](size_t r) HWY_ATTR { return outer[r]; },
      [&](size_t r) HWY_ATTR { return instance[r]; }, box);
  if (HWY_UNLIKELY(!is_in)) {
    for (size_t i = first; i <= last; ++i) tests_[i]->test(inside_[i]);
    return counts;
  }
  RaySlabs<W>::template setup_each<Group>([&](size_t r) HWY_ATTR { return &inside[r]->slabs; }, ray,
                                          box);
  for (size_t i = first; i <= last; ++i) {
    inside_[i].sight.prepare(inside_[i].ray.across(), inside_[i].ray.along());
    counts = visit(static_cast<uint32_t>(i), inside_[i].mesh->nodes[0], counts);
  }
  return counts;
}

template <int W, bool kAny>
typename InstanceStream<W, kAny>::Counts InstanceStream<W, kAny>::visit(uint32_t ray,
                                                                        const BvhNode<W>& node,
                                                                        Counts counts) {
  const Inside& inside = inside_[ray];
  alignas(64) float t_in[W];
  const uint32_t met = inside.slabs.overlapping(inside.ray, node, t_in);
  const auto child = load<UintOf<V>>(node.child);
  const uint32_t leaves = met & bits_of<IntOf<V>>(bit_cast<IntOf<V>>(child) < 0);
  return {nodes_.added(counts.nodes, child, met & ~leaves, ray),
          leaves_.added(counts.leaves, child, leaves, ray)};
}

// Rays that are not done with the nodes when there are too many go on by themselves.
template <int W, bool kAny>
typename InstanceStream<W, kAny>::Counts InstanceStream<W, kAny>::visit_nodes(Counts counts) {
  uint64_t done = 0;  // rays that went on by themselves
  for (size_t i = 0; i < counts.nodes; ++i) {
    const uint32_t ray = nodes_.ray[i];
    if (HWY_UNLIKELY(max_of(counts.nodes, counts.leaves) > kVisitsMost)) {
      if ((done >> ray & 1) == 0) tests_[ray]->test(inside_[ray]);
      done |= uint64_t{1} << ray;
    } else {
      counts = visit(ray, inside_[ray].mesh->nodes[nodes_.child[i]], counts);
    }
  }
  return counts;
}

template <int W, bool kAny>
void InstanceStream<W, kAny>::look_at(size_t leaves) {
  for (size_t i = 0; i < leaves; ++i) {
    const uint32_t ray = leaves_.ray[i], leaf = leaves_.child[i];
    const Inside& inside = inside_[ray];
    Test& test = *tests_[ray];
    if (kAny && test.ray().has_hit()) continue;
    const int32_t excluded[2] = {test.excluded(0, inside), test.excluded(1, inside)};
    const TriangleBlock<W>* block = inside.mesh->triangles + leaf_first(leaf);
    const TriangleBlock<W>* const end = block + leaf_count(leaf);
    do {
      TESSERA_COUNT(blocks, 1);
      const Candidates triangles = inside.sight.template look<false, true>(*block, 0, excluded);
      if (kAny && triangles.certain != 0) {
        test.settle(inside, *block, 0, triangles);
        break;
      }
      found_[found_count_] = {block, ray, triangles};
      found_count_ += triangles.possible != 0;
      if (HWY_UNLIKELY(found_count_ == kFoundMost)) settle_found();
    } while (HWY_UNLIKELY(++block != end));
  }
}

template <int W, bool kAny>
void InstanceStream<W, kAny>::settle_found() {
  for (size_t i = 0; i < found_count_; ++i) settle(found_[i]);
  pairs_.decide();
  found_count_ = 0;
}

template <int W, bool kAny>
void InstanceStream<W, kAny>::settle(const Found& found) {
  const Inside& inside = inside_[found.ray];
  Test& test = *tests_[found.ray];
  if (kAny && test.ray().has_hit()) return;
  const uint32_t open = found.triangles.possible & ~found.triangles.sure;
  constexpr int kFew = TriangleRay<W, kAny>::kFew;
  if (HWY_UNLIKELY(__builtin_popcount(open) > kFew))
    return test.settle(inside, *found.block, 0, found.triangles);
  for (uint32_t bits = found.triangles.possible; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(bits));
    Axes<FloatsOf<4>> corners[3];
    place_one(*found.block, lane, *inside.instance, corners);
    const uint32_t number = found.block->primitive[lane] + inside.instance->first_primitive;
    pairs_.add(test.ray(), corners, number, found.triangles.sure >> lane & 1u);
  }
}

template <int W, bool kAny>
void InstanceStream<W, kAny>::run() {
  Counts counts{0, 0};
  for (size_t i = 0; i < count_; i += Group::kRays) counts = enter(i, counts);
  counts = visit_nodes(counts);
  look_at(counts.leaves);
  settle_found();
}

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
