// SPDX-License-Identifier: Apache-2.0
// Leaves with places of shared surfaces whose sub-patches a method other than the usual one answers
// for, asked by single rays. Nothing is culled but by boxes and by the method itself.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/placed/method_places_layout.h"

#if defined(TESSERA_CORE_METHOD_PLACE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_METHOD_PLACE_LEAF_INL_H_
#undef TESSERA_CORE_METHOD_PLACE_LEAF_INL_H_
#else
#define TESSERA_CORE_METHOD_PLACE_LEAF_INL_H_
#endif

#include "slave/core/primitive/freeform/method_leaf-inl.h"
#include "slave/core/primitive/placed/place_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What answers for a sub-patch and one ray, in PlaceRayTest.
template <int W, bool kAny>
class PartsByMethod {
 public:
  static constexpr bool kIsUsual = false;

  HWY_INLINE PartsByMethod(OneRay& ray, TriangleRay<W, kAny>&) : ray_(ray) {}

  HWY_INLINE void test(const PlacesByMethod<W>& shapes, const Patch* patches,
                       const SubPatch& part) {
    ask_method<kAny>(shapes.method, patches, part, ray_);
  }

 private:
  OneRay& ray_;
};

template <int W>
struct LeafTests<PlacesByMethod<W>> {
  using Shapes = PlacesByMethod<W>;
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const Shapes& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
  template <bool kAny>
  using Ray = MixedRayLeaf<Shapes, W, kAny, PlaceRayTest<Shapes, W, kAny, PartsByMethod<W, kAny>>>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
