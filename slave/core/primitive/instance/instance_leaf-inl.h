// SPDX-License-Identifier: Apache-2.0
// Leaves with instances: rays go on through the structure of the mesh, in its own coordinates, and
// are tested against its triangles in world space: whole blocks for a packet, for a ray by itself
// those triangles that it may hit as seen in object space.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_INSTANCE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_INSTANCE_LEAF_INL_H_
#undef TESSERA_CORE_INSTANCE_LEAF_INL_H_
#else
#define TESSERA_CORE_INSTANCE_LEAF_INL_H_
#endif

#include "slave/core/primitive/instance/instance_ray-inl.h"
#include "slave/core/primitive/instance/instance_rays-inl.h"
#include "slave/core/primitive/instance/instance_stream-inl.h"
#include "slave/core/primitive/instance/placed-inl.h"
#include "slave/core/primitive/mixed_leaf-inl.h"
#include "slave/core/traverse/node_stack-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// What tests an instance against the rays of a packet, in MixedPacketLeaf.
template <int W, bool kAny, class Rays, template <int, bool> class Test>
class InstancePacketTest {
 public:
  HWY_INLINE InstancePacketTest(Rays& rays, Test<W, kAny>& test) : rays_(rays), test_(test) {}

  HWY_INLINE bool test(const TrianglesAndInstances<W>& shapes, uint32_t number) {
    const InstanceBlock& instance = shapes.instances[number];
    return test(mesh_of(shapes, instance), instance);
  }

 private:
  // What an instance costs before its first node, in tests of a row; see PacketTracer.
  static constexpr int kEnterWork = 4;

  HWY_NOINLINE bool test(const MeshShape<W>& mesh, const InstanceBlock& instance);

  Rays& rays_;
  Test<W, kAny>& test_;
  ObjectFrustum frustum_;
};

template <int W, bool kAny, class Rays, template <int, bool> class Test>
bool InstancePacketTest<W, kAny, Rays, Test>::test(const MeshShape<W>& mesh,
                                                   const InstanceBlock& instance) {
  if (HWY_UNLIKELY(mesh.nodes == nullptr)) return false;
  rays_.work_left -= kEnterWork;
  if (!frustum_.enter(rays_, instance, mesh.box)) {
    rays_.work_left = -1;  // the rays are traced one by one
    return false;
  }
  const MeshView<W> view = view_of(mesh);
  NodeStack<MeshView<W>> stack(view);
  alignas(64) float z_near[W];
  bool has_hit = false;
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
    bool is_hit = false;
    const TriangleBlock<W>* block = view.shapes.triangles + leaf_first(child);
    const TriangleBlock<W>* const end = block + leaf_count(child);
    for (; block != end; ++block) {
      TriangleBlock<W> placed;
      place(*block, instance, placed);
      is_hit |= test_.test(placed);
    }
    if (!is_hit) continue;
    has_hit = true;
    rays_.shorten();
    frustum_.shorten(rays_);
  }
  return has_hit;
}

// Leaf test of one ray, alone or in a stream (bvh_stream-inl.h).
template <int W, bool kAny>
class InstanceRayLeaf
    : public MixedRayLeaf<TrianglesAndInstances<W>, W, kAny, InstanceRayTest<W, kAny>> {
  using Shapes = TrianglesAndInstances<W>;

 public:
  using MixedRayLeaf<Shapes, W, kAny, InstanceRayTest<W, kAny>>::MixedRayLeaf;

  static HWY_INLINE bool leads_on(const Shapes& shapes, uint32_t block) {
    return (shapes.blocks[block] & kIsItem) != 0;
  }
#if HWY_TARGET == HWY_AVX3
  using Stream = InstanceStream<W, kAny>;
  HWY_INLINE void join(Stream& stream, const Shapes& shapes, uint32_t block) {
    stream.add(this->item_, shapes, shapes.blocks[block] ^ kIsItem);
  }
#endif
};

template <int W>
struct LeafTests<TrianglesAndInstances<W>> {
  using Shapes = TrianglesAndInstances<W>;
  static constexpr size_t kBlockBytes = kNumberBytes;
  static HWY_INLINE const char* address(const Shapes& shapes, uint32_t block) {
    return address_of_number(shapes, block);
  }
  template <bool kAny>
  using Ray = InstanceRayLeaf<W, kAny>;
  template <bool kAny>
  using Fan = MixedPacketLeaf<Shapes, W, kAny, FanRays, FanBlock,
                              InstancePacketTest<W, kAny, FanRays, FanBlock>>;
  template <bool kAny>
  using Bundle = MixedPacketLeaf<Shapes, W, kAny, BundleRays, BundleBlock,
                                 InstancePacketTest<W, kAny, BundleRays, BundleBlock>>;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
