// SPDX-License-Identifier: Apache-2.0
// Lists of a few primitives, in which each primitive is looked at for a row of rays: of which sets
// of kinds of primitives there are such lists.
//
// Threads. See the lists.
#include "slave/core/primitive/shapes_layout.h"

#if defined(TESSERA_CORE_LIST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LIST_INL_H_
#undef TESSERA_CORE_LIST_INL_H_
#else
#define TESSERA_CORE_LIST_INL_H_
#endif

#include "slave/core/primitive/triangle/triangle_list-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class Shapes>
struct PrimitiveLists {};

#if HWY_TARGET == HWY_AVX3
template <>
struct PrimitiveLists<TrianglesOnly<16>> {
  using List = TriangleList;
  // Returns: whether there was room.
  static HWY_INLINE bool add(const TrianglesOnly<16>& shapes, uint32_t block, List& list) {
    return list.add(shapes.triangles[block]);
  }
};
#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
