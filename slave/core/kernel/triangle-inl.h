// Watertight test of triangles against a bundle of 16 rays that share their main axis.
//
// After Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013: the vertices
// are moved to the ray's origin and sheared so that the ray is the z axis; inside or outside is
// then the sign of three 2D edge values. Differences: zero counts as inside, so no edge is
// recomputed in double, and all products are rounded on their own (no fused multiply-add). That is
// enough: rounding is monotonic, so fl(a b) > fl(c d) only if a b > c d, and a computed sign can be
// zero where the true one is not but never the opposite. Two triangles at an edge see the same two
// 2D points, so a ray that reaches the edge is inside at least one of them. Both sides are hit.
//
// Every comparison is false for NaN (overflowing coordinates): no hit.
#include "slave/core/kernel/bundle_layout.h"
#include "slave/core/kernel/scene_view_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_INL_H_
#undef TESSERA_CORE_TRIANGLE_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_INL_H_
#endif

#include "slave/core/kernel/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

using D = hn::CappedTag<float, kBundleRays>;
using DI = hn::CappedTag<int32_t, kBundleRays>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

constexpr size_t kLanes = hn::MaxLanes(D());
constexpr size_t kRows = static_cast<size_t>(kBundleRays) / kLanes;

// Greater than every primitive number (at most 2^30), so that a hit at exactly t_max beats it.
constexpr int32_t kPrimitiveNone = 0x7fffffff;

// Rays with the direction scaled as traverse-inl.h says, and the shear of the current main axis z:
// x, y are the next two axes in cyclic order. Lanes of rays with another main axis hold rubbish.
struct RayRows {
  V origin[3][kRows], direction[3][kRows];
  int axis[3] = {0, 1, 2};
  V shear_x[kRows], shear_y[kRows], shear_z[kRows];

  void set_main_axis(int z) {
    axis[2] = z;
    axis[0] = z == 2 ? 0 : z + 1;
    axis[1] = z == 0 ? 2 : z - 1;
    for (size_t r = 0; r < kRows; ++r) {
      shear_x[r] = hn::Div(direction[axis[0]][r], direction[z][r]);
      shear_y[r] = hn::Div(direction[axis[1]][r], direction[z][r]);
      shear_z[r] = hn::Div(hn::Set(D(), 1.0f), direction[z][r]);
    }
  }
};

// The best hit so far of each ray; without one t is the upper limit.
struct BestRows {
  V t_min[kRows], t[kRows], u[kRows], v[kRows];
  VI primitive[kRows];
};

// Tests the triangles of one leaf; rays whose interval is empty do not take part.
template <bool kAny>
HWY_INLINE void test_triangles(const SceneView& scene, uint32_t first, uint32_t count,
                               const RayRows& ray, const V* t_near, const V* t_far,
                               BestRows& best) {
  const D d;
  const DI di;
  const V zero = hn::Zero(d);
  const int kx = ray.axis[0], ky = ray.axis[1], kz = ray.axis[2];
  M active[kRows];
  bool is_row_active[kRows];
  for (size_t r = 0; r < kRows; ++r) {
    active[r] = hn::Le(t_near[r], t_far[r]);
    is_row_active[r] = !hn::AllFalse(d, active[r]);
  }
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t primitive = scene.refs[first + i];
    const float* vertices = scene.vertices + size_t{9} * primitive;
    for (size_t r = 0; r < kRows; ++r) {
      if (!is_row_active[r]) continue;
      const V ox = ray.origin[kx][r], oy = ray.origin[ky][r], oz = ray.origin[kz][r];
      const V sx = ray.shear_x[r], sy = ray.shear_y[r];
      const V az = hn::Sub(hn::Set(d, vertices[kz]), oz);
      const V bz = hn::Sub(hn::Set(d, vertices[3 + kz]), oz);
      const V cz = hn::Sub(hn::Set(d, vertices[6 + kz]), oz);
      const V ax = hn::Sub(hn::Sub(hn::Set(d, vertices[kx]), ox), hn::Mul(sx, az));
      const V ay = hn::Sub(hn::Sub(hn::Set(d, vertices[ky]), oy), hn::Mul(sy, az));
      const V bx = hn::Sub(hn::Sub(hn::Set(d, vertices[3 + kx]), ox), hn::Mul(sx, bz));
      const V by = hn::Sub(hn::Sub(hn::Set(d, vertices[3 + ky]), oy), hn::Mul(sy, bz));
      const V cx = hn::Sub(hn::Sub(hn::Set(d, vertices[6 + kx]), ox), hn::Mul(sx, cz));
      const V cy = hn::Sub(hn::Sub(hn::Set(d, vertices[6 + ky]), oy), hn::Mul(sy, cz));
      const V u = hn::Sub(hn::Mul(cx, by), hn::Mul(cy, bx));  // weights of A, B, C
      const V v = hn::Sub(hn::Mul(ax, cy), hn::Mul(ay, cx));
      const V w = hn::Sub(hn::Mul(bx, ay), hn::Mul(by, ax));
      const M front = hn::And(hn::And(hn::Ge(u, zero), hn::Ge(v, zero)), hn::Ge(w, zero));
      const M back = hn::And(hn::And(hn::Le(u, zero), hn::Le(v, zero)), hn::Le(w, zero));
      const M inside = hn::And(hn::Or(front, back), active[r]);
      if (hn::AllFalse(d, inside)) continue;

      const V det = hn::Add(hn::Add(u, v), w);  // zero when seen edge-on: no hit
      const V depth = hn::Add(hn::Add(hn::Mul(u, az), hn::Mul(v, bz)), hn::Mul(w, cz));
      const V t = hn::Mul(hn::Div(depth, det), ray.shear_z[r]);
      const VI number = hn::Set(di, static_cast<int32_t>(primitive));
      const M is_lower = hn::RebindMask(d, hn::Lt(number, best.primitive[r]));
      const M nearer = hn::Or(hn::Lt(t, best.t[r]), hn::And(hn::Eq(t, best.t[r]), is_lower));
      const M in_range = hn::And(hn::Ge(t, best.t_min[r]), nearer);
      const M hit = hn::And(hn::And(inside, in_range), hn::Ne(det, zero));
      if (hn::AllFalse(d, hit)) continue;
      const VI number_now = hn::IfThenElse(hn::RebindMask(di, hit), number, best.primitive[r]);
      best.primitive[r] = number_now;
      if constexpr (kAny) {
        best.t[r] = hn::IfThenElse(hit, hn::Set(d, -__builtin_inff()), best.t[r]);
      } else {
        best.t[r] = hn::IfThenElse(hit, t, best.t[r]);
        best.u[r] = hn::IfThenElse(hit, hn::Div(v, det), best.u[r]);
        best.v[r] = hn::IfThenElse(hit, hn::Div(w, det), best.v[r]);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
