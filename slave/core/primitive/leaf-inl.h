// SPDX-License-Identifier: Apache-2.0
// What traversals ask of leaves: which of the primitives in a run of blocks the rays hit. A
// traversal takes the leaf test of its rays as a template argument and knows nothing else of
// primitives.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/shapes_layout.h"

#if defined(TESSERA_CORE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LEAF_INL_H_
#undef TESSERA_CORE_LEAF_INL_H_
#else
#define TESSERA_CORE_LEAF_INL_H_
#endif

#include "slave/core/primitive/triangle/triangle_bundle-inl.h"
#include "slave/core/primitive/triangle/triangle_fan-inl.h"
#include "slave/core/primitive/triangle/triangle_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Leaf test of the rays of a packet. Test: FanBlock or BundleBlock.
template <int W, bool kAny, template <int, bool> class Test>
class PacketLeaf {
 public:
  static constexpr bool kIsAny = kAny;

  template <class Rays>
  explicit PacketLeaf(Rays& rays) : test_(rays) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() { test_.prepare(); }
  // Returns: whether some ray has a new best hit.
  HWY_INLINE bool test(const TrianglesOnly<W>& shapes, uint32_t first, uint32_t count) {
    const TriangleBlock<W>* block = shapes.triangles + first;
    const TriangleBlock<W>* const end = block + count;
    bool has_hit = false;
    for (; block != end; ++block) {
      if (block + 1 != end) fetch_lines<lines_of(sizeof *block)>(block + 1);
      has_hit |= test_.test(*block);
    }
    return has_hit;
  }
  // To be called after all tests.
  HWY_INLINE void finish() { test_.finish(); }

 private:
  Test<W, kAny> test_;
};

// Leaf test of one ray.
template <int W, bool kAny>
class RayLeaf {
 public:
  static constexpr bool kIsAny = kAny;
  static constexpr bool kSettlesAtOnce = true;
  using Found = Candidates;

  explicit RayLeaf(OneRay& ray) : test_(ray) {}

  HWY_INLINE void prepare() { test_.prepare(); }
  // Returns: for any-hit, the block with the hit; kNoBlock where there is none, and for closest
  // hits.
  HWY_INLINE uint32_t test(const TrianglesOnly<W>& shapes, uint32_t first, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      test_.test(shapes.triangles[first + i]);
      if (kAny && test_.has_hit()) return first + i;
    }
    return kNoBlock;
  }
  // What test() does for one block, in two steps, between which other rays have theirs.
  HWY_INLINE Found look(const TrianglesOnly<W>& shapes, uint32_t block) const {
    return test_.look(shapes.triangles[block]);
  }
  static HWY_INLINE bool may_hit(const Found& found) { return found.possible != 0; }
  // The second steps of rays in flight, each at once.
  class Settling {
   public:
    explicit Settling(const TrianglesOnly<W>& shapes) : shapes_(shapes) {}
    HWY_INLINE void settle(RayLeaf& leaf, uint32_t block, const Found& found) const {
      leaf.test_.settle(shapes_.triangles[block], found);
    }
    HWY_INLINE bool is_settled(const RayLeaf&) const { return true; }
    HWY_INLINE void finish() const {}

   private:
    const TrianglesOnly<W>& shapes_;
  };

 private:
  TriangleRay<W, kAny> test_;
};

// The leaf tests for a set of kinds of primitives, one for each kind of rays.
template <class Shapes>
struct LeafTests;
template <int W>
struct LeafTests<TrianglesOnly<W>> {
  // Address of a block, and its size, for fetching it ahead.
  static constexpr size_t kBlockBytes = sizeof(TriangleBlock<W>);
  static HWY_INLINE const char* address(const TrianglesOnly<W>& shapes, uint32_t block) {
    return reinterpret_cast<const char*>(shapes.triangles + block);
  }
  template <bool kAny>
  using Ray = RayLeaf<W, kAny>;
  template <bool kAny>
  using Fan = PacketLeaf<W, kAny, FanBlock>;
  template <bool kAny>
  using Bundle = PacketLeaf<W, kAny, BundleBlock>;
  using Twins = PacketLeaf<W, true, TwinBlock>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
