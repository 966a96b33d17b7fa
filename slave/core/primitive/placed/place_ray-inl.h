// SPDX-License-Identifier: Apache-2.0
// The test of a place of a shared surface against one ray: the ray goes on through the surface, in
// its coordinates; sub-patches that it may meet are asked in world space.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/freeform/placed_parts_abi.h"
#include "slave/core/primitive/places_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_PLACE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLACE_RAY_INL_H_
#undef TESSERA_CORE_PLACE_RAY_INL_H_
#else
#define TESSERA_CORE_PLACE_RAY_INL_H_
#endif

#include "slave/core/primitive/mixed_leaf-inl.h"
#include "slave/core/primitive/placed/object_packet-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What is in a shared surface, to traversals: blocks that name its sub-patches.
template <int W>
struct PartsOfSurface {
  const uint32_t* blocks;
};
template <int W>
using SurfaceView = BvhView<W, PartsOfSurface<W>>;
template <int W>
struct LeafTests<PartsOfSurface<W>> {
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const PartsOfSurface<W>& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
};

template <int W>
HWY_INLINE SurfaceView<W> view_of(const SurfaceShape<W>& surface) {
  return {surface.nodes, {surface.blocks}, surface.box};
}

// A place whose sub-patches are asked for.
template <int W>
struct PlaceOfSurface {
  HWY_INLINE PlaceOfSurface(const TrianglesAndPlaces<W>& shapes, uint32_t number)
      : place(shapes.places[number]),
        surface(shapes.surfaces[place.mesh]),
        number_of_all(shapes.first_place + number) {}

  HWY_INLINE const SubPatch& part(const uint32_t block) const {
    return surface.parts[surface.blocks[block] ^ kIsItem];
  }
  // The part's own number among those that rays ask for.
  HWY_INLINE uint32_t number_of(const SubPatch& part) const {
    return place.first_primitive + part.primitive;
  }
  HWY_INLINE PartInWorld in_world(const SubPatch& part) const {
    return part_in_world(place, number_of_all, surface.patches[part.patch], part);
  }

  const InstanceBlock& place;
  const SurfaceShape<W>& surface;
  uint64_t number_of_all;
};

// What tests an item against one ray, in MixedRayLeaf. Parts: what answers for a sub-patch, with
//   static constexpr bool kIsUsual       whether parts may be left out that the ray surely passes;
//   void test(const Shapes&, const Patch* patches, const SubPatch&), in world space; patches: those
//   that sub-patches name.
template <class Shapes, int W, bool kAny, class Parts>
class PlaceRayTest {
 public:
  HWY_INLINE PlaceRayTest(OneRay& ray, TriangleRay<W, kAny>& test) : ray_(ray), parts_(ray, test) {}

  HWY_INLINE void test(const Shapes& shapes, uint32_t number) {
    if (number < shapes.part_count)
      return parts_.test(shapes, shapes.patches, shapes.parts[number]);
    if (ray_.best_t >= ray_.t_min) enter(shapes, number - shapes.part_count);
  }

 private:
  HWY_NOINLINE void enter(const Shapes& shapes, uint32_t number);
  HWY_INLINE void ask(const Shapes& shapes, const PlaceOfSurface<W>& at, const SubPatch& part) {
    const PartInWorld there = at.in_world(part);
    parts_.test(shapes, there.patch, *there.part);
  }
  // Returns: whether the ray needs no further tests.
  HWY_INLINE bool test_leaf(const Shapes& shapes, const PlaceOfSurface<W>& at,
                            const ObjectSight& sight, uint32_t first, uint32_t count);

  OneRay& ray_;
  Parts parts_;
};

template <class Shapes, int W, bool kAny, class Parts>
bool PlaceRayTest<Shapes, W, kAny, Parts>::test_leaf(const Shapes& shapes,
                                                     const PlaceOfSurface<W>& at,
                                                     const ObjectSight& sight, uint32_t first,
                                                     uint32_t count) {
  for (uint32_t i = first; i < first + count; ++i) {
    const SubPatch& part = at.part(i);
    if (Parts::kIsUsual && part.has_frame && !PatchRayFilter::is_possible(sight, part)) continue;
    if (Parts::kIsUsual && ray_.excludes(at.number_of(part))) continue;
    ask(shapes, at, part);
    if (kAny && ray_.has_hit()) return true;
  }
  return false;
}

template <class Shapes, int W, bool kAny, class Parts>
void PlaceRayTest<Shapes, W, kAny, Parts>::enter(const Shapes& shapes, uint32_t number) {
  const PlaceOfSurface<W> at(shapes, number);
  ObjectRay inner;
  if (HWY_UNLIKELY(!inner.enter(ray_, at.place, at.surface.box))) {
    for (uint32_t p = 0; p < at.surface.part_count; ++p) {
      ask(shapes, at, at.surface.parts[p]);
      if (kAny && ray_.has_hit()) return;
    }
    return;
  }
  RaySlabs<W> slabs;
  slabs.setup(inner, at.surface.box);
  ObjectSight sight(inner);
  const SurfaceView<W> view = view_of(at.surface);
  NodeStack<SurfaceView<W>> stack(view, BelowRoot());
  alignas(64) float t_in[W];
  uint32_t child = 0;
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = view.nodes[child];
      const uint32_t met = slabs.overlapping(inner, node, t_in);
      child = kAny ? stack.descend_unsorted(node, met) : stack.descend(node, met, t_in);
      if (child != kBvhNoChild) continue;
    } else {
      if (test_leaf(shapes, at, sight, leaf_first(child), leaf_count(child))) return;
      inner.shorten(ray_);
      sight.shorten(inner);
    }
    child = stack.next(inner.far_limit);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
