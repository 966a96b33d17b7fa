// SPDX-License-Identifier: Apache-2.0
// The triangles of a block as a fan sees them: linear forms in u and v, whose signs and sizes tell
// which rays meet them and how near.
//
// Tolerance. u = 2^-24; s the largest coordinate of a corner from the origin, D the largest
// component of B - A, L the longest D, all computed; S = 1 + max|u| + max|v| bounds the sum of |d|.
// Let T' be the triangle whose corners are those of T, moved to the origin and rounded: each is off
// by u s per axis, less than 2 u s across the ray. For T', E is off by at most
//   14 S u s D  A + B, B - A: 2 u each of 4 s D; product and difference of the cross product
//    8 S u s D  the reciprocal of D and the products with it, 1 u each of 4 s D
//   20 S u s D  u, v (2 u each), the tolerance added to the constant, two fused steps
// whatever the ray. What E of T' has beyond that, over 2 |d| |B - A|, is the distance of the ray
// from the edge of T'. Where it is more than 2 u s on the inner side of all edges, moving the
// corners by as much takes none of them across the ray, so the ray is in T, too. Where it is as
// much outside of one, the ray is further from T' than any point of T. That takes 2 |d| |B - A| 2 u
// s, at most 7 S u s D. Together this is 49 S u s D; with the bound's own roundings 52 S u s D. An
// edge too short for its reciprocal tells nothing: its E is 0.
//
// Nearness. On the plane through T, 1/z = N.(u, v, 1) / N.A, which is linear in u and v. N comes
// from the edges of T itself; with s_k the sum of the sizes of the two products in its component k
// it is off by 4 u s_k. A - O is off by 1 u of each component, so N.A is off by 8 u H with H = sum
// of s_k |A_k|. That is counted as 10 u H, and where it is not below a quarter of N.A, nothing is
// known of the nearness. For a ray N.(u, v, 1) is off by
//    4 u G  N       2 u G  u, v       2 u G  reciprocal and product       2 u G  two fused steps
// with G = s_x max|u| + s_y max|v| + s_z. N.A adds 4/3 10 u H / |N.A| of G, and t as it is
// reported, with its 4 roundings, 5 u G. So the nearness of what would be reported is within
//    u G / |N.A| (17 + 15 H / |N.A|)
// of the computed one. Where these intervals of two triangles overlap, both t are computed.
//
// Orientation. Which side of an edge is the inner one follows from the side of the plane that the
// origin lies on. That is the sign of V = A.(B x C) = N.A, the same for all rays. d.N and d.N' of a
// ray differ by at most 8 S u s (L + u s) for the edges L of T, which are at most 2 u s longer than
// those of T', and where the ray hits, |d.N| is at least |V| / s, V at least 3/4 of what was
// computed. So where |V| is more than 17 S u s (L + 3 u s) s, T' is turned as T is, to the origin
// and to every ray that hits. Otherwise exact_side() says where the origin lies, and a ray with
// |d.N| not above 17 S u s (L + 3 u s) may see T' turned the other way. Such a ray is outside only
// where E says so whichever way that is; otherwise exact_hit() decides.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/triangle_layout.h"

#if defined(TESSERA_CORE_FAN_FORMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_FORMS_INL_H_
#undef TESSERA_CORE_FAN_FORMS_INL_H_
#else
#define TESSERA_CORE_FAN_FORMS_INL_H_
#endif

#include "slave/core/primitive/triangle/triangle_frustum-inl.h"
#include "slave/core/ray/fan_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// The edge functions of one of W triangles, at the rays of a row. Each number is put in all lanes
// where it is used: wide registers are loaded so.
template <int W>
struct EdgesInPlace {
  using V = FanRays::V;

  HWY_INLINE V value(size_t c, V u, V v) const {
    const auto part = [&](size_t k) HWY_ATTR { return set<V>(edges[c][k][lane]); };
    return mul_add(u, part(0), mul_add(v, part(1), part(2)));
  }

  const float (*edges)[3][W];  // FanForms::edges
  size_t lane;
};

// The same where there are many rows: each number is put in all lanes once for all of them.
struct SpreadEdges {
  using V = FanRays::V;

  template <int W>
  HWY_INLINE SpreadEdges(const float (*edges)[3][W], size_t lane) {
    for (size_t c = 0; c < 3; ++c) {
      for (size_t k = 0; k < 3; ++k) parts[c][k] = set<V>(edges[c][k][lane]);
    }
  }
  HWY_INLINE V value(size_t c, V u, V v) const {
    return mul_add(u, parts[c][0], mul_add(v, parts[c][1], parts[c][2]));
  }

  V parts[3][3];
};

// Rays: FanRays or TwinRays.
template <int W, class Rays>
class FanForms {
  using VB = FloatsOf<W>;  // triangles
  using MB = MaskOf<VB>;
  using Tests = FrustumTriangles<W>;
  static constexpr size_t kLanes = FanRays::kLanes;
  static constexpr size_t kRows = FanRays::kRows;

 public:
  static constexpr bool kCullsRows = FanRays::kCullsRows;

  explicit FanForms(const Rays& fan) : fan_(fan) {}

  // Requires, before the first block: the rays are set up.
  HWY_INLINE void prepare() { tolerance_ = 52 * kRoundoff * fan_.steepness; }

  // Bits of triangles of a block: `met`, those that the frustum may meet; of those, `unsure`, whose
  // orientation is not sure, and `close`, which may lie before t_min.
  struct Kept {
    uint32_t met = 0, unsure = 0, close = 0;
  };
  // Makes the forms of the triangles from lane `first` on. keep: those that are not culled yet.
  // planes: those of the fan, or the fan itself.
  template <class Planes>
  HWY_INLINE Kept look_at(const Planes& planes, const TriangleBlock<W>& block, size_t first,
                          const Corners<VB>& p, MB keep);
  // Reverses the edge functions of a triangle.
  void turn(size_t lane);
  // Returns: the rows that may meet a triangle: all three edges let the row's best corner through,
  // and the row looks as far as the triangle.
  HWY_INLINE uint64_t rows_of(size_t lane) const;
  HWY_INLINE auto edges_of(size_t lane) const {
    if constexpr (FanRays::kHasManyRows) {
      return SpreadEdges(edges, lane);
    } else {
      return EdgesInPlace<W>{edges, lane};
    }
  }

  // For each triangle:
  //   edges     edge functions over the lengths of the edges, with the tolerance added
  //   twice     twice the tolerance
  //   nearness  the linear form of its nearness; doubt: how far that may be off
  //   steep     the least |d.N| / |N.A| with which T' is turned as T is
  //   sides     N.A, by whose sign the edges were turned
  //   begins    the depth at which it begins
  alignas(64) float edges[3][3][W], twice[W];
  alignas(64) float nearness[3][W], doubt[W], steep[W];
  alignas(64) float sides[W], begins[W];

 private:
  HWY_INLINE MB set_nearness(const TriangleBlock<W>& block, size_t first, const Corners<VB>& p,
                             VB largest, MB& is_close);

  const Rays& fan_;
  float tolerance_;  // 52 S u
};

// largest: the largest coordinate of each. Returns: the triangles whose nearness is known.
// is_close: those that may lie before t_min.
template <int W, class Rays>
typename FanForms<W, Rays>::MB FanForms<W, Rays>::set_nearness(const TriangleBlock<W>& block,
                                                               size_t first, const Corners<VB>& p,
                                                               VB largest, MB& is_close) {
  constexpr float kTiny = 0x1p-122f;  // more than products lose by underflow
  const auto edge = [&](int corner, int axis) {
    return load<VB>(block.vertex[3 * corner + axis] + first) - load<VB>(block.vertex[axis] + first);
  };
  const VB bx = edge(1, fan_.kx), by = edge(1, fan_.ky), bz = edge(1, fan_.kz) * fan_.side;
  const VB cx = edge(2, fan_.kx), cy = edge(2, fan_.ky), cz = edge(2, fan_.kz) * fan_.side;
  const VB zy = bz * cy, xz = bx * cz, yx = by * cx;
  const VB nx = mul_sub(by, cz, zy), ny = mul_sub(bz, cx, xz), nz = mul_sub(bx, cy, yx);
  const auto sizes = [&](VB a, VB b, VB other) {
    return mul_add(abs(a), abs(b), abs(other) + kTiny);
  };
  const VB sx = sizes(by, cz, zy), sy = sizes(bz, cx, xz), sz = sizes(bx, cy, yx);
  const VB volume = mul_add(nx, p.x[0], mul_add(ny, p.y[0], nz * p.z[0]));
  const VB size =
      mul_add(sx, abs(p.x[0]), mul_add(sy, abs(p.y[0]), mul_add(sz, abs(p.z[0]), set<VB>(kTiny))));
  const VB spread = mul_add(sx, set<VB>(fan_.widest[0]), mul_add(sy, set<VB>(fan_.widest[1]), sz));
  const VB over = 1 / volume;
  const VB g = spread * abs(over), h = size * abs(over);
  const auto is_good = h <= 1 / (40 * kRoundoff) && abs(volume) >= 0x1p-100f &&
                       abs(volume) <= 0x1p100f && g < 0x1p120f;
  const VB slack = g * mul_add(h, set<VB>(15 * kRoundoff), set<VB>(17 * kRoundoff)) + kUnderflow;
  store(zero_unless(is_good, nx * over), nearness[0] + first);
  store(zero_unless(is_good, ny * over), nearness[1] + first);
  store(zero_unless(is_good, nz * over), nearness[2] + first);
  const VB known = select(is_good, slack, set<VB>(__builtin_inff()));
  store(known, doubt + first);
  store(volume, sides + first);
  is_close = g * 1.0001f + slack >= fan_.nearest_min;
  const VB thin = tolerance_ * largest * (17.0f / 52) * 1.0001f;  // to be multiplied by L + 3 u s
  store(thin, steep + first);
  return is_good;
}

template <int W, class Rays>
template <class Planes>
typename FanForms<W, Rays>::Kept FanForms<W, Rays>::look_at(const Planes& planes,
                                                            const TriangleBlock<W>& block,
                                                            size_t first, const Corners<VB>& p,
                                                            MB keep) {
  MB is_close;
  const VB size = Tests::sizes(p);
  const MB is_good = set_nearness(block, first, p, size, is_close);
  const VB volume = load<VB>(sides + first);
  const VB sign = bit_cast<VB>(bit_cast<UintOf<VB>>(volume) & 0x80000000u);
  VB edge[3][3], length[3], over[3];
  for (int c = 0; c < 3; ++c) {
    const int e = (c + 1) % 3;
    const VB ax = p.x[c] + p.x[e], ay = p.y[c] + p.y[e], az = p.z[c] + p.z[e];
    const VB dx = p.x[e] - p.x[c], dy = p.y[e] - p.y[c], dz = p.z[e] - p.z[c];
    length[c] = Tests::largest(abs(dx), abs(dy), abs(dz));
    over[c] = zero_unless(length[c] >= 0x1p-100f, 1 / length[c]);
    edge[c][0] = mul_sub(ay, dz, az * dy) * over[c];
    edge[c][1] = mul_sub(az, dx, ax * dz) * over[c];
    edge[c][2] = mul_sub(ax, dy, ay * dx) * over[c];
  }
  const VB tolerance =
      mul_add(Tests::largest(over[0], over[1], over[2]), set<VB>(kUnderflow), tolerance_ * size);
  store(tolerance + tolerance, twice + first);
  const VB longest = Tests::largest(length[0], length[1], length[2]);
  const VB thin = mul_add(load<VB>(steep + first), mul_add(size, set<VB>(3 * kRoundoff), longest),
                          set<VB>(kUnderflow));
  const MB is_sure = is_good && abs(volume) * 0.75f > thin * size;
  const MB is_unsure = !is_sure;
  store(thin * 1.34f / abs(volume) + load<VB>(doubt + first), steep + first);
  store(p.z_low, begins + first);
  for (int c = 0; c < 3; ++c) {
    const auto turned = [&](VB x) {
      return bit_cast<VB>(bit_cast<UintOf<VB>>(x) ^ bit_cast<UintOf<VB>>(sign));
    };
    const VB nx = turned(edge[c][0]), ny = turned(edge[c][1]);
    const VB nz = turned(edge[c][2]) + tolerance;
    // The largest value of the edge function at a corner of the packet.
    const VB across = max(nx * planes.slope_u[0], nx * planes.slope_u[1]);
    const VB up = max(ny * planes.slope_v[0], ny * planes.slope_v[1]);
    keep = keep && (is_unsure || across + up + nz >= 0);
    store(nx, edges[c][0] + first);
    store(ny, edges[c][1] + first);
    store(nz, edges[c][2] + first);
  }
  return {bits_of<VB>(keep) << first, bits_of<VB>(is_unsure) << first,
          bits_of<VB>(is_close) << first};
}

template <int W, class Rays>
void FanForms<W, Rays>::turn(size_t lane) {
  for (size_t c = 0; c < 3; ++c) {
    edges[c][0][lane] = -edges[c][0][lane];
    edges[c][1][lane] = -edges[c][1][lane];
    edges[c][2][lane] = twice[lane] - edges[c][2][lane];
  }
}

template <int W, class Rays>
uint64_t FanForms<W, Rays>::rows_of(size_t lane) const {
  uint64_t rows = 0;
  if constexpr (kCullsRows) {
    using VR = FloatsOf<(kRows < kLanes ? kRows : kLanes)>;
    for (size_t first = 0; first < kRows; first += kLanesOf<VR>) {
      const auto best_of = [&](float x, float y, float z) {
        const auto u = load<VR>(fan_.row_u[x >= 0] + first);
        const auto v = load<VR>(fan_.row_v[y >= 0] + first);
        return mul_add(u, set<VR>(x), mul_add(v, set<VR>(y), set<VR>(z)));
      };
      const auto edge = [&](int c) {
        return best_of(edges[c][0][lane], edges[c][1][lane], edges[c][2][lane]);
      };
      const auto inside = min(min(edge(0), edge(1)), edge(2));
      const auto is_near = load<VR>(fan_.row_low + first) * begins[lane] <= 1 + kTimeSlack;
      rows |= uint64_t{bits_of<VR>(is_near && inside >= 0)} << first;
    }
  }
  return rows;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
