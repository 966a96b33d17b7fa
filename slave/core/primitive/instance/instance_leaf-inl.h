// SPDX-License-Identifier: Apache-2.0
// Leaves with instances: rays go on through the structure of the mesh, in its own coordinates, and
// are tested against its triangles in world space. These are brought there by the operations that
// flatten a scene, so an instance gives the bits of the same triangles flattened: whole blocks for
// a packet, for a ray by itself those triangles that it may hit as seen in object space.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/instance/mesh_slot_abi.h"
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_INSTANCE_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_INSTANCE_LEAF_INL_H_
#undef TESSERA_CORE_INSTANCE_LEAF_INL_H_
#else
#define TESSERA_CORE_INSTANCE_LEAF_INL_H_
#endif

#include "slave/core/primitive/instance/instance_rays-inl.h"
#include "slave/core/primitive/mixed_leaf-inl.h"
#include "slave/core/simd/real-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W>
using MeshView = BvhView<W, TrianglesOnly<W>>;

// The mesh of an instance that rays have reached; without nodes where it cannot be had.
template <int W>
HWY_INLINE const MeshShape<W>& mesh_of(const TrianglesAndInstances<W>& shapes,
                                       const InstanceBlock& instance) {
  const MeshShape<W>& mesh = shapes.meshes[instance.mesh];
  return HWY_UNLIKELY(mesh.nodes == nullptr) && is_slot(mesh) ? met_mesh(mesh) : mesh;
}

template <int W>
HWY_INLINE MeshView<W> view_of(const MeshShape<W>& mesh) {
  return {mesh.nodes, {mesh.triangles}, mesh.box};
}

// Brings a block to world space. Corners are computed as by Transform::point(), without fused
// operations; an identity leaves them as they are, zeros with a sign, too.
template <int W>
HWY_INLINE void place(const TriangleBlock<W>& block, const InstanceBlock& instance,
                      TriangleBlock<W>& placed) {
  using V = FloatsOf<W>;
  for (size_t i = 0; i < W; i += kLanesOf<V>) {
    for (size_t c = 0; c < 9; c += 3) {
      const auto x = load<V>(block.vertex[c] + i), y = load<V>(block.vertex[c + 1] + i);
      const auto z = load<V>(block.vertex[c + 2] + i);
      for (size_t a = 0; a < 3; ++a) {
        const float* const row = instance.to_world[a];
        const auto sum = row[0] * x + row[1] * y;
        const auto at = sum + row[2] * z + row[3];
        store(at, placed.vertex[c + a] + i);
      }
    }
    const auto number = load<UintOf<V>>(block.primitive + i);
    store(number + instance.first_primitive, placed.primitive + i);
  }
  if (HWY_UNLIKELY(instance.is_identity != 0)) {
    for (size_t k = 0; k < 9; ++k) {
      for (size_t i = 0; i < W; i += kLanesOf<V>)
        store(load<V>(block.vertex[k] + i), placed.vertex[k] + i);
    }
  }
}

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

// Corners of one triangle in world space, as place() brings them there.
template <int W>
HWY_INLINE void place_one(const TriangleBlock<W>& block, size_t lane, const InstanceBlock& instance,
                          TriangleBlock<W>& placed) {
  const bool is_moved = instance.is_identity == 0;
  for (size_t c = 0; c < 9; c += 3) {
    const float given[3] = {block.vertex[c][lane], block.vertex[c + 1][lane],
                            block.vertex[c + 2][lane]};
    for (size_t a = 0; a < 3; ++a) {
      const float* const row = instance.to_world[a];
      const float sum = row[0] * given[0] + row[1] * given[1];
      const float at = sum + row[2] * given[2] + row[3];
      placed.vertex[c + a][0] = is_moved ? at : given[a];
    }
  }
  placed.primitive[0] = block.primitive[lane] + instance.first_primitive;
}

// One ray within an instance: where it is in object space, and what it meets of the mesh's root.
template <int W, bool kAny>
struct RayInside {
  ObjectRay ray;
  RaySlabs<W> slabs;
  TriangleSight<W, kAny> sight{ray};
  const InstanceBlock* instance;
  const MeshShape<W>* mesh;
  uint32_t met;  // children of the root
  alignas(64) float t_in[W];
};

// What tests an instance against one ray, in MixedRayLeaf.
template <int W, bool kAny>
class InstanceRayTest {
 public:
  HWY_INLINE InstanceRayTest(OneRay& ray, TriangleRay<W, kAny>& test) : ray_(ray), test_(test) {}

  HWY_INLINE void test(const TrianglesAndInstances<W>& shapes, uint32_t number) {
    RayInside<W, kAny> inside;
    if (enter(shapes, number, inside)) traverse(inside);
  }
  // What test() does, in two steps. Returns: whether the second is to be done.
  HWY_INLINE bool enter(const TrianglesAndInstances<W>& shapes, uint32_t number,
                        RayInside<W, kAny>& inside);
  HWY_NOINLINE void traverse(RayInside<W, kAny>& inside);

 private:
  // Tests blocks until the ray needs no further tests. Returns: whether that is so.
  HWY_INLINE bool test_placed(const InstanceBlock& instance, const TriangleBlock<W>* blocks,
                              uint32_t count);
  HWY_INLINE bool test(const RayInside<W, kAny>& inside, const TriangleBlock<W>* blocks,
                       uint32_t count);
  HWY_INLINE void settle(const RayInside<W, kAny>& inside, const TriangleBlock<W>& block,
                         size_t first, const Candidates& found);
  HWY_NOINLINE void test_all(const InstanceBlock& instance, const MeshShape<W>& mesh) {
    test_placed(instance, mesh.triangles, mesh.block_count);
  }

  OneRay& ray_;
  TriangleRay<W, kAny>& test_;
};

template <int W, bool kAny>
bool InstanceRayTest<W, kAny>::test_placed(const InstanceBlock& instance,
                                           const TriangleBlock<W>* blocks, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    TriangleBlock<W> placed;
    place(blocks[i], instance, placed);
    test_.test(placed);
    if (kAny && test_.has_hit()) return true;
  }
  return false;
}

// Looks at triangles in object space and takes to world space what may be hit.
template <int W, bool kAny>
bool InstanceRayTest<W, kAny>::test(const RayInside<W, kAny>& inside,
                                    const TriangleBlock<W>* blocks, uint32_t count) {
  int32_t excluded[2];  // -1 and numbers of other instances are none of the mesh's
  for (size_t k = 0; k < 2; ++k)
    excluded[k] = ray_.excluded[k] - static_cast<int32_t>(inside.instance->first_primitive);
  for (uint32_t i = 0; i < count; ++i) {
    TESSERA_COUNT(blocks, 1);
    for (size_t first = 0; first < W; first += TriangleSight<W, kAny>::kStep) {
      const Candidates found = inside.sight.template look<kAny, true>(blocks[i], first, excluded);
      if (found.possible != 0) settle(inside, blocks[i], first, found);
      if (kAny && test_.has_hit()) return true;
    }
  }
  return false;
}

template <int W, bool kAny>
void InstanceRayTest<W, kAny>::settle(const RayInside<W, kAny>& inside,
                                      const TriangleBlock<W>& block, size_t first,
                                      const Candidates& found) {
  const InstanceBlock& instance = *inside.instance;
  if (kAny && found.certain != 0) {
    const auto lane = first + static_cast<size_t>(__builtin_ctz(found.certain));
    const uint32_t number = block.primitive[lane] + instance.first_primitive;
    return ray_.template accept<kAny>(ray_.best_t, static_cast<int32_t>(number));
  }
  const uint32_t open = found.possible & ~found.sure;
  constexpr int kFew = TriangleRay<W, kAny>::kFew;
  if (HWY_UNLIKELY(__builtin_popcount(open) > kFew)) {
    test_placed(instance, &block, 1);
    return;
  }
  TriangleBlock<W> placed;
  for (uint32_t bits = found.possible; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(bits));
    place_one(block, first + lane, instance, placed);
    test_.test_triangle(placed, 0, found.sure >> lane & 1u);
  }
}

template <int W, bool kAny>
bool InstanceRayTest<W, kAny>::enter(const TrianglesAndInstances<W>& shapes, uint32_t number,
                                     RayInside<W, kAny>& inside) {
  const InstanceBlock& instance = shapes.instances[number];
  const MeshShape<W>& mesh = mesh_of(shapes, instance);
  if (ray_.best_t < ray_.t_min || HWY_UNLIKELY(mesh.nodes == nullptr)) return false;
  if (HWY_UNLIKELY(!inside.ray.enter(ray_, instance, mesh.box))) {
    test_all(instance, mesh);
    return false;
  }
  inside.slabs.setup(inside.ray, mesh.box);
  inside.sight.prepare(inside.ray.across(), inside.ray.along());
  inside.instance = &instance;
  inside.mesh = &mesh;
  inside.met = inside.slabs.overlapping(inside.ray, mesh.nodes[0], inside.t_in);
  return inside.met != 0;
}

template <int W, bool kAny>
void InstanceRayTest<W, kAny>::traverse(RayInside<W, kAny>& inside) {
  ObjectRay& inner = inside.ray;
  inner.shorten(ray_);  // since it went in
  const MeshView<W> view = view_of(*inside.mesh);
  NodeStack<MeshView<W>> stack(view, BelowRoot());
  const auto step_down = [&](const BvhNode<W>& node, uint32_t met) HWY_ATTR {
    return kAny ? stack.descend_unsorted(node, met) : stack.descend(node, met, inside.t_in);
  };
  uint32_t child = step_down(view.nodes[0], inside.met);
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = view.nodes[child];
      child = step_down(node, inside.slabs.overlapping(inner, node, inside.t_in));
      if (child != kBvhNoChild) continue;
    } else {
      const TriangleBlock<W>* const blocks = view.shapes.triangles + leaf_first(child);
      if (test(inside, blocks, leaf_count(child))) return;
      inner.shorten(ray_);
    }
    child = stack.next(inner.far_limit);
  }
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
  HWY_INLINE bool enter(const Shapes& shapes, uint32_t block) {
    return this->item_.enter(shapes, shapes.blocks[block] ^ kIsItem, inside_);
  }
  HWY_INLINE void traverse() { this->item_.traverse(inside_); }

 private:
  RayInside<W, kAny> inside_;
};

template <int W>
struct LeafTests<TrianglesAndInstances<W>> {
  using Shapes = TrianglesAndInstances<W>;
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
