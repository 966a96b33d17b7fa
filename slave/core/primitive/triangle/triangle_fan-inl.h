// SPDX-License-Identifier: Apache-2.0
// The triangles of a block against a fan: culled by the frustum before any ray sees them.
//
// Decisions. A ray meets a triangle A, B, C where it passes its three edges on one side. With E = d
// . ((A + B) x (B - A)) = 2 d . (A x B) that is a sign. E is computed in float32, and
//     E < -tol for one edge    surely outside,
//     E >  tol for all three   surely inside,
//     else                     exact_hit() decides, which is exact.
// A triangle is therefore hit by the rays that hit it in exact arithmetic, whatever the rounding
// here, and fused multiply-adds may be used for E. What is reported, t, is computed without them,
// by the same operations in every kernel (plane-inl.h).
//
// Tolerance. u = 2^-24; s the largest coordinate of a corner from the origin, D the largest
// component of B - A, L the longest D, all computed; S = 1 + max|u| + max|v| bounds the sum of |d|.
// Let T' be the triangle whose corners are those of T, moved to the origin and rounded: each is off
// by u s per axis, less than 2 u s across the ray. For T', E is off by at most
//   14 S u s D  A + B, B - A: 2 u each of 4 s D; product and difference of the cross product
//   16 S u s D  u, v (1 u each), the tolerance added to the constant, two fused steps
// whatever the ray. What E of T' has beyond that, over 2 |d| |B - A|, is the distance of the ray
// from the edge of T'; where it is more than 2 u s on the inner side of all edges, moving the
// corners by as much takes none of them across the ray, so the ray is in T, too; where it is as
// much outside of one, the ray is further from T' than any point of T. That takes 2 |d| |B - A| 2 u
// s, at most 7 S u s D. Together 37 S u s D; with the bound's own roundings 40 S u s D.
//
// Orientation. Which side is the inner one is the side of the origin, the same for all rays: the
// sign of V = A.(B x C). 2 V is computed with an error of 72 u s s L and V' differs from V by 24 u
// s s L; d.N and d.N' of a ray differ by 8 S u s L, and where the ray hits, |d.N| is at least |V| /
// s. So where 2 |V| is more than (120 + 16 S) u s s L, T' is turned as T is, to the origin and to
// every ray that hits. Else exact_side() says where the origin lies, and a ray with |d.N| not above
// 16 S u s L may see T' turned the other way: it is outside only where E says so whichever way that
// is, and else exact_hit() decides.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_FAN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_FAN_INL_H_
#undef TESSERA_CORE_TRIANGLE_FAN_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_FAN_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/primitive/triangle/triangle_frustum-inl.h"
#include "slave/core/ray/fan_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
class FanBlock {
  using D = FanRays::D;  // rays
  using V = FanRays::V;
  using B = hn::CappedTag<float, W>;  // triangles
  using VB = hn::Vec<B>;
  using Tests = FrustumTriangles<W>;
  static constexpr size_t kLanes = FanRays::kLanes;
  static constexpr size_t kRows = FanRays::kRows;
  static constexpr size_t kStep = hn::MaxLanes(B());

 public:
  static constexpr bool kIsAny = kAny;
  explicit FanBlock(FanRays& fan) : fan_(fan) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() { tolerance_ = 40 * kRoundoff * fan_.steepness; }

  // Returns: whether some ray has a new best hit.
  bool test(const TriangleBlock<W>& block);

 private:
  HWY_INLINE uint32_t cull(const TriangleBlock<W>& block, size_t first, uint32_t& unsure);
  HWY_NOINLINE bool test_unsure(const TriangleBlock<W>& block, size_t lane);
  void turn(size_t lane);
  HWY_INLINE uint64_t rows_of(size_t lane) const;
  template <bool kUnsure>
  HWY_INLINE bool test_rows(const TriangleBlock<W>& block, size_t lane, uint64_t rows);
  template <bool kUnsure>
  HWY_INLINE bool test_row(const TriangleBlock<W>& block, size_t lane, size_t row,
                           const Plane& plane);
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, size_t ray,
                           const Plane& plane);

  FanRays& fan_;
  // Of the block at hand, by edge: its function with the tolerance added, and twice the tolerance.
  alignas(64) float edge_[3][3][W], twice_[3][W];
  alignas(64) float thin_[W], volume_[W], z_low_[W];
  float tolerance_;  // 40 S u
};

// Edge functions of the triangles of a block from lane `first` on. Returns: the bits of those that
// the frustum may meet; unsure: of those whose orientation is not sure.
template <int W, bool kAny>
uint32_t FanBlock<W, kAny>::cull(const TriangleBlock<W>& block, size_t first, uint32_t& unsure) {
  const B b;
  const Corners<VB> p = Tests::corners(fan_, block, first);
  auto keep = Tests::triangles(fan_, p);
  if (kAny) {
    const hn::RebindToSigned<B> bi;
    const auto number = hn::Load(bi, reinterpret_cast<const int32_t*>(block.primitive) + first);
    keep = hn::And(keep, hn::RebindMask(b, hn::Ne(number, hn::Set(bi, fan_.excluded))));
  }
  if (hn::AllFalse(b, keep)) return 0;

  VB edge[3][3], length[3];
  for (int c = 0; c < 3; ++c) {
    const int e = (c + 1) % 3;
    const VB sx = hn::Add(p.x[c], p.x[e]), sy = hn::Add(p.y[c], p.y[e]),
             sz = hn::Add(p.z[c], p.z[e]);
    const VB dx = hn::Sub(p.x[e], p.x[c]), dy = hn::Sub(p.y[e], p.y[c]),
             dz = hn::Sub(p.z[e], p.z[c]);
    edge[c][0] = hn::MulSub(sy, dz, hn::Mul(sz, dy));
    edge[c][1] = hn::MulSub(sz, dx, hn::Mul(sx, dz));
    edge[c][2] = hn::MulSub(sx, dy, hn::Mul(sy, dx));
    length[c] = Tests::largest(hn::Abs(dx), hn::Abs(dy), hn::Abs(dz));
  }
  // The side of the origin, the same for all rays: 2 A . (B x C). Faces turned away are turned
  // round.
  const VB volume =
      hn::MulAdd(edge[1][0], p.x[0], hn::MulAdd(edge[1][1], p.y[0], hn::Mul(edge[1][2], p.z[0])));
  const VB per_length = hn::Mul(p.size, hn::Set(b, tolerance_));
  const VB longest = Tests::largest(length[0], length[1], length[2]);
  // tolerance is 40 S u, so 4 of it are 160 S u: enough for S >= 1.
  const VB thin = hn::MulAdd(longest, per_length, hn::Set(b, kUnderflow));
  const VB least = hn::Mul(thin, hn::Mul(p.size, hn::Set(b, 4)));
  const auto is_sure = hn::And(hn::Gt(hn::Abs(volume), least), hn::Lt(hn::Abs(volume), hn::Inf(b)));
  const auto is_unsure = hn::Not(is_sure);
  const VB sign = hn::And(volume, hn::Set(b, -0.0f));
  hn::Store(thin, b, thin_ + first);
  hn::Store(volume, b, volume_ + first);
  hn::Store(p.z_low, b, z_low_ + first);
  for (int c = 0; c < 3; ++c) {
    const VB tolerance = hn::MulAdd(length[c], per_length, hn::Set(b, kUnderflow));
    const VB nx = hn::Xor(edge[c][0], sign), ny = hn::Xor(edge[c][1], sign);
    const VB nz = hn::Add(hn::Xor(edge[c][2], sign), tolerance);
    // The largest value at a corner of the packet.
    const VB across =
        hn::Max(hn::Mul(nx, hn::Set(b, fan_.slope_u[0])), hn::Mul(nx, hn::Set(b, fan_.slope_u[1])));
    const VB up =
        hn::Max(hn::Mul(ny, hn::Set(b, fan_.slope_v[0])), hn::Mul(ny, hn::Set(b, fan_.slope_v[1])));
    keep = hn::And(keep, hn::Or(is_unsure, hn::Ge(hn::Add(hn::Add(across, up), nz), hn::Zero(b))));
    hn::Store(nx, b, edge_[c][0] + first);
    hn::Store(ny, b, edge_[c][1] + first);
    hn::Store(nz, b, edge_[c][2] + first);
    hn::Store(hn::Add(tolerance, tolerance), b, twice_[c] + first);
  }
  unsure = bits_of(b, is_unsure) << first;
  return bits_of(b, keep) << first;
}

template <int W, bool kAny>
bool FanBlock<W, kAny>::test(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  bool has_hit = false;
  for (size_t first = 0; first < W; first += kStep) {
    uint32_t unsure = 0;
    for (uint32_t bits = cull(block, first, unsure); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      TESSERA_COUNT(candidates, 1);
      if ((unsure >> lane & 1u) != 0) {
        has_hit |= test_unsure(block, lane);
      } else {
        const uint64_t rows = rows_of(lane);
        fan_.work_left -= 2 + __builtin_popcountll(rows);
        has_hit |= test_rows<false>(block, lane, rows);
      }
    }
  }
  return has_hit;
}

// A triangle whose side of the origin is not known for sure.
template <int W, bool kAny>
bool FanBlock<W, kAny>::test_unsure(const TriangleBlock<W>& block, size_t lane) {
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  if (!has_area(triangle)) return false;
  const int side = exact_side(fan_.origin, triangle);
  if (side == 0) {  // only rays that start in the triangle can touch it
    const Plane plane = plane_of(block, lane, fan_.origin);
    bool has_hit = false;
    for (size_t ray = 0; ray < kPacketRays; ++ray) has_hit |= decide(block, lane, ray, plane);
    return has_hit;
  }
  const bool is_behind = static_cast<float>(side) * fan_.side < 0;
  const bool is_right = is_behind == (__builtin_signbit(volume_[lane]) != 0);
  const uint64_t rows = rows_of(lane);  // as computed, and turned round
  turn(lane);
  const uint64_t other_rows = rows_of(lane);
  if (is_right) turn(lane);
  return test_rows<true>(block, lane, rows | other_rows);
}

// Turns the edge functions of a triangle round.
template <int W, bool kAny>
void FanBlock<W, kAny>::turn(size_t lane) {
  for (size_t c = 0; c < 3; ++c) {
    edge_[c][0][lane] = -edge_[c][0][lane];
    edge_[c][1][lane] = -edge_[c][1][lane];
    edge_[c][2][lane] = twice_[c][lane] - edge_[c][2][lane];
  }
}

// Rows that all three edges let through at their best corner and that look as far as the triangle.
template <int W, bool kAny>
uint64_t FanBlock<W, kAny>::rows_of(size_t lane) const {
  const hn::CappedTag<float, (kRows < kLanes ? kRows : kLanes)> d;
  uint64_t rows = 0;
  for (size_t first = 0; first < kRows; first += hn::MaxLanes(d)) {
    const auto value = [&](int c) {
      const float nx = edge_[c][0][lane], ny = edge_[c][1][lane];
      const auto u = hn::Load(d, fan_.row_u[nx >= 0] + first);
      const auto v = hn::Load(d, fan_.row_v[ny >= 0] + first);
      return hn::MulAdd(u, hn::Set(d, nx),
                        hn::MulAdd(v, hn::Set(d, ny), hn::Set(d, edge_[c][2][lane])));
    };
    const auto best = hn::Min(hn::Min(value(0), value(1)), value(2));
    const auto is_near = hn::Ge(hn::Load(d, fan_.row_far + first), hn::Set(d, z_low_[lane]));
    rows |= uint64_t{bits_of(d, hn::And(is_near, hn::Ge(best, hn::Zero(d))))} << first;
  }
  return rows;
}

template <int W, bool kAny>
template <bool kUnsure>
bool FanBlock<W, kAny>::test_rows(const TriangleBlock<W>& block, size_t lane, uint64_t rows) {
  if (rows == 0) return false;
  bool has_hit = false;
  const Plane plane = plane_of(block, lane, fan_.origin);
  for (; rows != 0; rows &= rows - 1) {
    has_hit |= test_row<kUnsure>(block, lane, static_cast<size_t>(__builtin_ctzll(rows)), plane);
  }
  return has_hit;
}

template <int W, bool kAny>
template <bool kUnsure>
bool FanBlock<W, kAny>::test_row(const TriangleBlock<W>& block, size_t lane, size_t row,
                                 const Plane& plane) {
  const D d;
  TESSERA_COUNT(row_tests, 1);
  const size_t at = row * kLanes;
  const V u = hn::Load(d, fan_.ray_u + at), v = hn::Load(d, fan_.ray_v + at);
  const auto value = [&](int c) {
    return hn::MulAdd(u, hn::Set(d, edge_[c][0][lane]),
                      hn::MulAdd(v, hn::Set(d, edge_[c][1][lane]), hn::Set(d, edge_[c][2][lane])));
  };
  const V e0 = value(0), e1 = value(1), e2 = value(2);
  const auto is_inner = hn::Ge(hn::Min(hn::Min(e0, e1), e2), hn::Zero(d));
  auto is_possible = is_inner;
  if (kUnsure) {  // or inside of the triangle turned round
    const auto over = [&](V e, int c) { return hn::Sub(e, hn::Set(d, twice_[c][lane])); };
    const V most = hn::Max(hn::Max(over(e0, 0), over(e1, 1)), over(e2, 2));
    is_possible = hn::Or(is_possible, hn::Le(most, hn::Zero(d)));
  }
  if (hn::AllFalse(d, is_possible)) return false;

  TESSERA_COUNT(times, 1);
  const V speed = speed_of(fan_, plane, at);
  const V t = hn::Div(hn::Set(d, plane.distance), speed);
  const V least = hn::Add(hn::Mul(hn::Set(d, plane.steepness), hn::Load(d, fan_.length + at)),
                          hn::Set(d, kPlaneLeast));
  const auto counts = hn::Ge(hn::Abs(speed), least);
  auto is_sure = counts;
  if (kUnsure) {
    // The bound is that of a ray of z = 1; rays are no longer than `length` times that.
    const float thin = static_cast<float>(plane.scale * static_cast<double>(thin_[lane]));
    const V widest = hn::Mul(hn::Set(d, thin), hn::Load(d, fan_.length + at));
    const auto is_thick = hn::Gt(hn::Abs(speed), widest);
    is_sure = hn::And(is_sure, is_thick);
    is_possible = hn::And(is_possible, hn::Or(is_inner, hn::Not(is_thick)));
  }
  is_sure = hn::And(is_sure, hn::Gt(e0, hn::Set(d, twice_[0][lane])));
  is_sure = hn::And(is_sure, hn::Gt(e1, hn::Set(d, twice_[1][lane])));
  is_sure = hn::And(is_sure, hn::Gt(e2, hn::Set(d, twice_[2][lane])));
  bool has_hit = false;
  uint32_t open =
      fan_.template take<kAny>(row, {t, counts, is_possible, is_sure, hn::Set(d, fan_.t_min)},
                               block.primitive[lane], has_hit);
  for (; open != 0; open &= open - 1) {
    has_hit |= decide(block, lane, at + static_cast<size_t>(__builtin_ctz(open)), plane);
  }
  return has_hit;
}

// One ray that the filter leaves open.
template <int W, bool kAny>
bool FanBlock<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, size_t ray,
                               const Plane& plane) {
  TESSERA_COUNT(exact, 1);
  float triangle[9], direction[3];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  for (size_t k = 0; k < 3; ++k) direction[k] = fan_.direction[k][ray];
  const ExactHit exact = exact_hit(fan_.origin, direction, triangle);
  if (!exact.is_hit) return false;
  float speed = 0, t = 0;
  if (!plane_t(plane, direction, fan_.length[ray], speed, t)) t = exact.t;
  return fan_.template take<kAny>(ray, t, fan_.t_min, block.primitive[lane]);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
