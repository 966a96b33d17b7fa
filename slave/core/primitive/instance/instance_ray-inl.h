// SPDX-License-Identifier: Apache-2.0
// The test of an instance against one ray: the ray goes on through the mesh, in its coordinates,
// where triangles are looked at first; those that it may hit are brought to world space.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/instance_layout.h"

#if defined(TESSERA_CORE_INSTANCE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_INSTANCE_RAY_INL_H_
#undef TESSERA_CORE_INSTANCE_RAY_INL_H_
#else
#define TESSERA_CORE_INSTANCE_RAY_INL_H_
#endif

#include "slave/core/primitive/instance/instance_rays-inl.h"
#include "slave/core/primitive/instance/placed-inl.h"
#include "slave/core/primitive/leaf-inl.h"
#include "slave/core/simd/real-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// One ray within an instance: where it is in object space.
template <int W, bool kAny>
struct RayInside {
  ObjectRay ray;
  RaySlabs<W> slabs;
  TriangleSight<W, kAny> sight{ray};
  const InstanceBlock* instance;
  const MeshShape<W>* mesh;
};

// What tests an instance against one ray, in MixedRayLeaf.
template <int W, bool kAny>
class InstanceRayTest {
 public:
  HWY_INLINE InstanceRayTest(OneRay& ray, TriangleRay<W, kAny>& test) : ray_(ray), test_(test) {}

  HWY_INLINE void test(const TrianglesAndInstances<W>& shapes, uint32_t number) {
    RayInside<W, kAny> inside;
    if (find(shapes, number, inside)) test(inside);
  }
  // What test() does, in two steps: finds the instance and its mesh, and tests them. Returns:
  // whether there is something to test.
  HWY_INLINE bool find(const TrianglesAndInstances<W>& shapes, uint32_t number,
                       RayInside<W, kAny>& inside) const;
  HWY_NOINLINE void test(RayInside<W, kAny>& inside);
  // Tests a block, of which something may be hit.
  HWY_INLINE void settle(const RayInside<W, kAny>& inside, const TriangleBlock<W>& block,
                         size_t first, const Candidates& found);
  OneRay& ray() const { return ray_; }
  // Excluded number k of the ray within the mesh; -1 and numbers of other instances are none of the
  // mesh's.
  HWY_INLINE int32_t excluded(size_t k, const RayInside<W, kAny>& inside) const {
    return ray_.excluded[k] - static_cast<int32_t>(inside.instance->first_primitive);
  }

 private:
  void traverse(RayInside<W, kAny>& inside);
  // Tests blocks until the ray needs no further tests. Returns: whether that is so.
  HWY_INLINE bool test_placed(const InstanceBlock& instance, const TriangleBlock<W>* blocks,
                              uint32_t count);
  HWY_INLINE bool test(const RayInside<W, kAny>& inside, const TriangleBlock<W>* blocks,
                       uint32_t count);
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
  const int32_t excluded_here[2] = {excluded(0, inside), excluded(1, inside)};
  for (uint32_t i = 0; i < count; ++i) {
    TESSERA_COUNT(blocks, 1);
    for (size_t first = 0; first < W; first += TriangleSight<W, kAny>::kStep) {
      const Candidates found =
          inside.sight.template look<kAny, true>(blocks[i], first, excluded_here);
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
    Axes<FloatsOf<4>> corners[3];
    alignas(16) float by_axis[3][4];
    place_one(block, first + lane, instance, corners);
    for (size_t a = 0; a < 3; ++a) {
      corners[a].store_each([&](size_t) HWY_ATTR { return by_axis[a]; });
      for (size_t c = 0; c < 3; ++c) placed.vertex[3 * c + a][0] = by_axis[a][c];
    }
    placed.primitive[0] = block.primitive[first + lane] + instance.first_primitive;
    test_.test_triangle(placed, 0, found.sure >> lane & 1u);
  }
}

template <int W, bool kAny>
bool InstanceRayTest<W, kAny>::find(const TrianglesAndInstances<W>& shapes, uint32_t number,
                                    RayInside<W, kAny>& inside) const {
  inside.instance = &shapes.instances[number];
  inside.mesh = &mesh_of(shapes, *inside.instance);
  return ray_.best_t >= ray_.t_min && HWY_LIKELY(inside.mesh->nodes != nullptr);
}

template <int W, bool kAny>
void InstanceRayTest<W, kAny>::test(RayInside<W, kAny>& inside) {
  const MeshShape<W>& mesh = *inside.mesh;
  if (HWY_UNLIKELY(!inside.ray.enter(ray_, *inside.instance, mesh.box)))
    return test_all(*inside.instance, mesh);
  inside.slabs.setup(inside.ray, mesh.box);
  inside.sight.prepare(inside.ray.across(), inside.ray.along());
  traverse(inside);
}

template <int W, bool kAny>
HWY_INLINE void InstanceRayTest<W, kAny>::traverse(RayInside<W, kAny>& inside) {
  ObjectRay& inner = inside.ray;
  const MeshView<W> view = view_of(*inside.mesh);
  NodeStack<MeshView<W>> stack(view, BelowRoot());
  alignas(64) float t_in[W];
  uint32_t child = 0;
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = view.nodes[child];
      const uint32_t met = inside.slabs.overlapping(inner, node, t_in);
      child = kAny ? stack.descend_unsorted(node, met) : stack.descend(node, met, t_in);
      if (child != kBvhNoChild) continue;
    } else {
      const TriangleBlock<W>* const blocks = view.shapes.triangles + leaf_first(child);
      if (test(inside, blocks, leaf_count(child))) return;
      inner.shorten(ray_);
    }
    child = stack.next(inner.far_limit);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
