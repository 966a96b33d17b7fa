// SPDX-License-Identifier: Apache-2.0
// Leaves with sub-patches: each ray asks each of them, in world space.
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

#include "slave/core/primitive/leaf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE void origin_of(const FanRays& rays, size_t, float* to) {
  for (int a = 0; a < 3; ++a) to[a] = rays.origin[a];
}
HWY_INLINE void origin_of(const BundleRays& rays, size_t ray, float* to) {
  for (int a = 0; a < 3; ++a) to[a] = rays.from[a][ray];
}
HWY_INLINE float least_t(const FanRays& rays, size_t) { return rays.t_min; }
HWY_INLINE float least_t(const BundleRays& rays, size_t ray) { return rays.t_min[ray]; }

// Leaf test of the rays of a packet. Test: FanBlock or BundleBlock.
template <int W, bool kAny, class Rays, template <int, bool> class Test>
class PatchPacketLeaf {
 public:
  static constexpr bool kIsAny = kAny;

  explicit PatchPacketLeaf(Rays& rays) : rays_(rays), test_(rays) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() {
    rays_.line_up();
    test_.prepare();
  }

  // Returns: whether some ray has a new best hit.
  HWY_INLINE bool test(const TrianglesAndPatches<W>& shapes, uint32_t first, uint32_t count) {
    bool has_hit = false;
    for (uint32_t i = first; i < first + count; ++i) {
      const uint32_t block = shapes.blocks[i];
      if ((block & kIsItem) == 0) {
        has_hit |= test_.test(shapes.triangles[block]);
      } else {
        const SubPatch& part = shapes.parts[block ^ kIsItem];
        has_hit |= test(shapes.patches[part.patch], part);
      }
    }
    return has_hit;
  }
  // To be called after all tests.
  HWY_INLINE void finish() { test_.finish(); }

 private:
  HWY_NOINLINE bool test(const Patch& patch, const SubPatch& part);

  Rays& rays_;
  Test<W, kAny> test_;
};

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PatchPacketLeaf<W, kAny, Rays, Test>::test(const Patch& patch, const SubPatch& part) {
  bool has_hit = false;
  for (size_t ray = 0; ray < kPacketRays; ++ray) {
    const float t_min = least_t(rays_, ray);
    if (!(rays_.best_t[ray] >= t_min)) continue;
    float origin[3], direction[3];
    origin_of(rays_, ray, origin);
    rays_.direction_of(ray, direction);
    const PatchAnswer answer = patch_answer(patch, part, origin, direction, t_min);
    if (!answer.is_hit) continue;
    if (!kAny) test_.settle(ray);
    has_hit |= rays_.template take<kAny>(ray, answer.t, t_min, part.primitive);
  }
  return has_hit;
}

// Leaf test of one ray.
template <int W, bool kAny>
class PatchRayLeaf {
 public:
  static constexpr bool kIsAny = kAny;

  explicit PatchRayLeaf(OneRay& ray) : ray_(ray), test_(ray) {}

  HWY_INLINE void prepare() { test_.prepare(); }
  // Returns: for any-hit, the block with the hit; kNoBlock where there is none, and for closest
  // hits.
  HWY_INLINE uint32_t test(const TrianglesAndPatches<W>& shapes, uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i) {
      const uint32_t block = shapes.blocks[i];
      if ((block & kIsItem) == 0) {
        test_.test(shapes.triangles[block]);
      } else {
        const SubPatch& part = shapes.parts[block ^ kIsItem];
        test(shapes.patches[part.patch], part);
      }
      if (kAny && test_.has_hit()) return i;
    }
    return kNoBlock;
  }

 private:
  HWY_NOINLINE void test(const Patch& patch, const SubPatch& part) {
    const PatchAnswer answer = patch_answer(patch, part, ray_.origin, ray_.direction, ray_.t_min);
    const auto number = static_cast<int32_t>(part.primitive);
    if (answer.is_hit && ray_.is_nearer(answer.t, number))
      ray_.template accept<kAny>(answer.t, number);
  }

  OneRay& ray_;
  TriangleRay<W, kAny> test_;
};

template <int W>
struct LeafTests<TrianglesAndPatches<W>> {
  // Address to prefetch for a block: that of its number, before which nothing is known of the
  // block.
  static HWY_INLINE const char* address(const TrianglesAndPatches<W>& shapes, uint32_t block) {
    return reinterpret_cast<const char*>(shapes.blocks + block);
  }
  template <bool kAny>
  using Ray = PatchRayLeaf<W, kAny>;
  template <bool kAny>
  using Fan = PatchPacketLeaf<W, kAny, FanRays, FanBlock>;
  template <bool kAny>
  using Bundle = PatchPacketLeaf<W, kAny, BundleRays, BundleBlock>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
