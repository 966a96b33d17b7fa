// SPDX-License-Identifier: Apache-2.0
// Leaves with places of shared surfaces, beside sub-patches and triangles in world space. Rays of a
// packet go on through the surface as one frustum, in its coordinates. Sub-patches that none of
// them may meet are left out there (object_packet-inl.h); the others come to world space and are
// asked as those of flattened surfaces.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/places_layout.h"

#if defined(TESSERA_CORE_PLACE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLACE_LEAF_INL_H_
#undef TESSERA_CORE_PLACE_LEAF_INL_H_
#else
#define TESSERA_CORE_PLACE_LEAF_INL_H_
#endif

#include "slave/core/primitive/freeform/patch_leaf-inl.h"
#include "slave/core/primitive/placed/place_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What tests an item against the rays of a packet, in MixedPacketLeaf.
template <int W, bool kAny, class Rays, template <int, bool> class Test>
class PlacePacketTest {
 public:
  HWY_INLINE PlacePacketTest(Rays& rays, Test<W, kAny>& test) : rays_(rays), parts_(rays, test) {}

  HWY_INLINE bool test(const TrianglesAndPlaces<W>& shapes, uint32_t number) {
    if (number >= shapes.part_count)
      return enter(PlaceOfSurface<W>(shapes, number - shapes.part_count));
    return parts_.test(shapes.patches, shapes.parts[number]);
  }
  HWY_INLINE void prepare() { parts_.prepare(); }
  HWY_INLINE bool settle_waiting() { return parts_.settle_waiting(); }

 private:
  // What a place costs before its first node, in tests of a row; see PacketTracer.
  static constexpr int kEnterWork = 4;

  HWY_NOINLINE bool enter(const PlaceOfSurface<W>& at);
  // Whether some ray may meet the part, as seen in object space.
  HWY_INLINE bool may_meet(const PlaceOfSurface<W>& at, const SubPatch& part) const {
    if (!part.has_frame) return true;
    const Patch& patch = at.surface.patches[part.patch];
    return PatchHull::helps(patch, part) ? may_meet(part, PatchHull(patch, part))
                                         : may_meet(part, NothingMore());
  }
  template <class More>
  HWY_INLINE bool may_meet(const SubPatch& part, const More& more) const {
    const PatchFilter<ObjectPacket<Rays>> filter(inside_, part);
    uint32_t possible = 0;
    for (size_t row = 0; row < kPacketRays && possible == 0; row += kLaneCount)
      possible = filter.possible(row, more);
    return possible != 0;
  }
  HWY_INLINE bool test_leaf(const PlaceOfSurface<W>& at, uint32_t first, uint32_t count);

  Rays& rays_;
  PatchPacketTest<W, kAny, Rays, Test> parts_;
  ObjectFrustum frustum_;
  ObjectPacket<Rays> inside_{rays_};
};

// Returns: whether some ray has a new best hit.
template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PlacePacketTest<W, kAny, Rays, Test>::test_leaf(const PlaceOfSurface<W>& at, uint32_t first,
                                                     uint32_t count) {
  bool is_hit = false;
  for (uint32_t i = first; i < first + count; ++i) {
    const SubPatch& part = at.part(i);
    if (!may_meet(at, part)) continue;
    // What waits to be asked names parts of the table that is dropped where there is no room.
    if (HWY_UNLIKELY(!has_room_for_part())) is_hit |= parts_.settle_waiting();
    const PartInWorld there = at.in_world(part);
    is_hit |= parts_.test(there.patch, *there.part);
  }
  return is_hit;
}

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool PlacePacketTest<W, kAny, Rays, Test>::enter(const PlaceOfSurface<W>& at) {
  rays_.work_left -= kEnterWork;
  if (!frustum_.enter(rays_, at.place, at.surface.box)) {
    rays_.work_left = -1;  // the rays are traced one by one
    return false;
  }
  const SurfaceView<W> view = view_of(at.surface);
  NodeStack<SurfaceView<W>> stack(view);
  alignas(64) float z_near[W];
  bool has_hit = false, is_inside = false;
  int steps = 0;
  for (uint32_t child = stack.next(frustum_.z_far); child != kBvhNoChild;
       child = stack.next(frustum_.z_far)) {
    while ((child & kBvhLeaf) == 0) {
      if (++steps > Rays::kStepsMax) rays_.work_left = -1;
      const BvhNode<W>& node = view.nodes[child];
      child = stack.descend(node, FrustumTests<W>::boxes(frustum_, node, z_near), z_near);
    }
    if (rays_.work_left < 0) return has_hit;
    if (child == kBvhNoChild) continue;
    if (!is_inside) inside_.enter(at.place, at.surface.box);
    is_inside = true;
    if (!test_leaf(at, leaf_first(child), leaf_count(child))) continue;
    has_hit = true;
    rays_.shorten();
    frustum_.shorten(rays_);
  }
  return has_hit;
}

// What answers for a sub-patch and one ray, in PlaceRayTest.
template <int W, bool kAny>
class UsualParts {
 public:
  static constexpr bool kIsUsual = true;

  HWY_INLINE UsualParts(OneRay& ray, TriangleRay<W, kAny>& test) : test_(ray, test) {}

  HWY_INLINE void test(const TrianglesAndPlaces<W>&, const Patch* patches, const SubPatch& part) {
    if (test_.may_meet(part)) test_.ask(patches, part);
  }

 private:
  PatchRayTest<W, kAny> test_;
};

template <int W>
struct LeafTests<TrianglesAndPlaces<W>> {
  using Shapes = TrianglesAndPlaces<W>;
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const Shapes& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
  template <bool kAny>
  using Ray = MixedRayLeaf<Shapes, W, kAny, PlaceRayTest<Shapes, W, kAny, UsualParts<W, kAny>>>;
  template <bool kAny>
  using Fan = MixedPacketLeaf<Shapes, W, kAny, FanRays, FanBlock,
                              PlacePacketTest<W, kAny, FanRays, FanBlock>>;
  template <bool kAny>
  using Bundle = MixedPacketLeaf<Shapes, W, kAny, BundleRays, BundleBlock,
                                 PlacePacketTest<W, kAny, BundleRays, BundleBlock>>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
