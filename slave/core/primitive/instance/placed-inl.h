// SPDX-License-Identifier: Apache-2.0
// The mesh of an instance, and its triangles in world space: brought there by the operations that
// flatten a scene, so an instance gives the bits of the same triangles flattened.
//
// Threads. Pure functions.
#include "slave/core/primitive/instance/mesh_slot_abi.h"
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_PLACED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLACED_INL_H_
#undef TESSERA_CORE_PLACED_INL_H_
#else
#define TESSERA_CORE_PLACED_INL_H_
#endif

#include "slave/core/ray/axes-inl.h"
#include "slave/core/simd/real-inl.h"

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

// Corners of one triangle in world space, as place() brings them there: at[a] has axis a of A, B
// and C.
template <int W>
HWY_INLINE void place_one(const TriangleBlock<W>& block, size_t lane, const InstanceBlock& instance,
                          Axes<FloatsOf<4>> (&at)[3]) {
  using Corners = Axes<FloatsOf<4>>;
  const auto given = [&](size_t a) HWY_ATTR {
    return Corners::of_three(block.vertex[a][lane], block.vertex[3 + a][lane],
                             block.vertex[6 + a][lane]);
  };
  const Corners x = given(0), y = given(1), z = given(2);
  for (size_t a = 0; a < 3; ++a) {
    const float* const row = instance.to_world[a];
    const Corners sum = Corners::all(row[0]) * x + Corners::all(row[1]) * y;
    at[a] = sum + Corners::all(row[2]) * z + Corners::all(row[3]);
  }
  if (HWY_UNLIKELY(instance.is_identity != 0)) {
    at[0] = x;
    at[1] = y;
    at[2] = z;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
