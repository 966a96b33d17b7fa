// SPDX-License-Identifier: Apache-2.0
// Leaves of two kinds: triangles side by side, and items of another kind by number
// (shapes_layout.h).
//
// Threads. As the tests that are passed.
#include "slave/core/primitive/shapes_layout.h"

#if defined(TESSERA_CORE_MIXED_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_MIXED_LEAF_INL_H_
#undef TESSERA_CORE_MIXED_LEAF_INL_H_
#else
#define TESSERA_CORE_MIXED_LEAF_INL_H_
#endif

#include "slave/core/primitive/leaf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Leaf test of the rays of a packet. Test: FanBlock or BundleBlock, for triangles. Item: what tests
// an item, with
//   Item(Rays&, Test<W, kAny>&), both of which outlive it;
//   bool test(const Shapes&, uint32_t number): whether some ray has a new best hit;
//   void prepare(), where it has something to do before tests;
//   bool settle_waiting(), where some of what is tested is put off: the same of that.
template <class Shapes, int W, bool kAny, class Rays, template <int, bool> class Test, class Item>
class MixedPacketLeaf {
 public:
  static constexpr bool kIsAny = kAny;

  explicit MixedPacketLeaf(Rays& rays) : rays_(rays), test_(rays), item_(rays, test_) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() {
    rays_.line_up();
    test_.prepare();
    if constexpr (requires { item_.prepare(); }) item_.prepare();
  }

  // Returns: whether some ray has a new best hit.
  HWY_INLINE bool test(const Shapes& shapes, uint32_t first, uint32_t count) {
    bool has_hit = false;
    for (uint32_t i = first; i < first + count; ++i) {
      const uint32_t block = shapes.blocks[i];
      has_hit |= (block & kIsItem) == 0 ? test_.test(shapes.triangles[block])
                                        : item_.test(shapes, block ^ kIsItem);
    }
    return has_hit;
  }
  // Settles what items put off. To be called after all tests, and before a ray's answer is read.
  HWY_INLINE void settle_waiting() requires requires(Item item) { item.settle_waiting(); }
  { item_.settle_waiting(); }
  // To be called after all tests.
  HWY_INLINE void finish() { test_.finish(); }

 private:
  Rays& rays_;
  Test<W, kAny> test_;
  Item item_;
};

// Leaf test of one ray. Item: as above, with Item(OneRay&, TriangleRay<W, kAny>&) and
//   void test(const Shapes&, uint32_t number).
template <class Shapes, int W, bool kAny, class Item>
class MixedRayLeaf {
 public:
  static constexpr bool kIsAny = kAny;

  explicit MixedRayLeaf(OneRay& ray) : test_(ray), item_(ray, test_) {}

  HWY_INLINE void prepare() { test_.prepare(); }
  // Returns: for any-hit, the block with the hit; kNoBlock where there is none, and for closest
  // hits.
  HWY_INLINE uint32_t test(const Shapes& shapes, uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i) {
      const uint32_t block = shapes.blocks[i];
      if ((block & kIsItem) == 0) {
        test_.test(shapes.triangles[block]);
      } else {
        item_.test(shapes, block ^ kIsItem);
      }
      if (kAny && test_.has_hit()) return i;
    }
    return kNoBlock;
  }

 protected:
  TriangleRay<W, kAny> test_;
  Item item_;
};

// What is fetched ahead for a block: its number, before which nothing is known of the block.
constexpr size_t kNumberBytes = sizeof(uint32_t);
template <class Shapes>
HWY_INLINE const char* address_of_number(const Shapes& shapes, uint32_t block) {
  return reinterpret_cast<const char*>(shapes.blocks + block);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
