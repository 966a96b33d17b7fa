// SPDX-License-Identifier: Apache-2.0
// Leaves with sub-patches that a method other than the usual one answers for, asked by single rays.
// Nothing is culled here but by the method itself, which is what is measured.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/freeform/method_shapes_layout.h"

#if defined(TESSERA_CORE_METHOD_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_METHOD_LEAF_INL_H_
#undef TESSERA_CORE_METHOD_LEAF_INL_H_
#else
#define TESSERA_CORE_METHOD_LEAF_INL_H_
#endif

#include "slave/core/primitive/freeform/patch_pairs-inl.h"
#include "slave/core/primitive/mixed_leaf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Asks the method for a sub-patch, and for those that it stands for. patches: those that they name.
template <bool kAny>
HWY_NOINLINE void ask_method(const PatchMethodCall& method, const Patch* patches,
                             const SubPatch& part, OneRay& ray) {
  const auto ask = [&](const SubPatch& one) HWY_ATTR {
    const PatchAnswer answer =
        method.answer(method.how, patches[one.patch], one, ray.origin, ray.direction, ray.t_min);
    const auto number = static_cast<int32_t>(one.primitive);
    if (answer.is_hit && ray.is_nearer(answer.t, number))
      ray.template accept<kAny>(answer.t, number);
  };
  ask(part);
  if (!is_border_span(part)) return;
  for (const SubPatch* span = next_beside(part); span != nullptr; span = next_beside(*span))
    ask(*span);
}

// What tests a sub-patch against one ray, in MixedRayLeaf.
template <int W, bool kAny>
class MethodRayTest {
 public:
  HWY_INLINE MethodRayTest(OneRay& ray, TriangleRay<W, kAny>&) : ray_(ray) {}

  HWY_INLINE void test(const PatchesByMethod<W>& shapes, uint32_t item) {
    ask_method<kAny>(shapes.method, shapes.patches, shapes.parts[item], ray_);
  }

 private:
  OneRay& ray_;
};

template <int W>
struct LeafTests<PatchesByMethod<W>> {
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const PatchesByMethod<W>& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
  template <bool kAny>
  using Ray = MixedRayLeaf<PatchesByMethod<W>, W, kAny, MethodRayTest<W, kAny>>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
