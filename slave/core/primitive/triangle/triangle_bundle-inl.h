// SPDX-License-Identifier: Apache-2.0
// The triangles of a block against a bundle of rays with origins of their own: culled by the
// frustum, then by the planes of each row, then tested by 4, 8 or 16 rays at once.
//
// Decisions and tolerances are those of triangle_ray-inl.h, lane by lane.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_BUNDLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_BUNDLE_INL_H_
#undef TESSERA_CORE_TRIANGLE_BUNDLE_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_BUNDLE_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/primitive/triangle/triangle_frustum-inl.h"
#include "slave/core/primitive/triangle/triangle_ray-inl.h"
#include "slave/core/ray/bundle_rays-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
class BundleBlock {
  using D = BundleRays::D;  // rays
  using V = BundleRays::V;
  using M = BundleRays::M;
  using VB = FloatsOf<W>;  // triangles
  using Tests = FrustumTriangles<W>;
  static constexpr size_t kLanes = BundleRays::kLanes;
  static constexpr size_t kRows = BundleRays::kRows;
  static constexpr size_t kStep = kLanesOf<VB>;
  // Up to so many open rays of a row are decided at once; see triangle_ray-inl.h.
  static constexpr int kFew = static_cast<int>(kLanes / 4);

 public:
  static constexpr bool kIsAny = kAny;
  explicit BundleBlock(BundleRays& rays) : rays_(rays) {}

  void prepare() {}
  void settle(size_t) {}
  void finish() {}

  // Returns: whether some ray has a new best hit.
  bool test(const TriangleBlock<W>& block);

 private:
  HWY_INLINE uint64_t rows_of(size_t lane) const;
  HWY_INLINE bool test_row(const TriangleBlock<W>& block, size_t lane, size_t row,
                           const Plane& plane);
  HWY_INLINE V distance_of(const TriangleBlock<W>& block, size_t lane, size_t at,
                           const Plane& plane) const;
  HWY_NOINLINE uint32_t elsewhere(const TriangleBlock<W>& block, size_t lane, size_t at) const;
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, size_t ray);

  BundleRays& rays_;
  // Corners of the block that is being tested, from the frustum's origin.
  alignas(64) float x_[3][W], y_[3][W], z_[3][W], size_[W], z_low_[W];
};

template <int W, bool kAny>
bool BundleBlock<W, kAny>::test(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  bool has_hit = false;
  for (size_t first = 0; first < W; first += kStep) {
    const Corners<VB> p = Tests::corners(rays_, block, first);
    uint32_t bits = bits_of<VB>(Tests::triangles(rays_, rays_, p));
    if (bits == 0) continue;
    for (int c = 0; c < 3; ++c) {
      store(p.x[c], x_[c] + first);
      store(p.y[c], y_[c] + first);
      store(p.z[c], z_[c] + first);
    }
    store(Tests::sizes(p), size_ + first);
    store(p.z_low, z_low_ + first);
    for (; bits != 0; bits &= bits - 1) {
      const size_t lane = first + static_cast<size_t>(__builtin_ctz(bits));
      TESSERA_COUNT(candidates, 1);
      uint64_t rows = rows_of(lane);
      rays_.work_left -= 2 + __builtin_popcountll(rows);
      if (rows == 0) continue;
      const Plane plane = plane_of(block, lane, rays_.origin);
      for (; rows != 0; rows &= rows - 1) {
        has_hit |= test_row(block, lane, static_cast<size_t>(__builtin_ctzll(rows)), plane);
      }
    }
  }
  return has_hit;
}

// Returns: the rows that may meet a triangle: it has a corner on the inner side of each of their
// planes, and they look as far as the triangle.
template <int W, bool kAny>
uint64_t BundleBlock<W, kAny>::rows_of(size_t lane) const {
  using VR = FloatsOf<(kRows < kLanes ? kRows : kLanes)>;  // rows
  const VR slack = set<VR>(-4 * kRoundoff * size_[lane]);
  uint64_t rows = 0;
  for (size_t first = 0; first < kRows; first += kLanesOf<VR>) {
    const auto meets = [&](const BundleRays::RowPlanes& planes, int which, const float(*q)[W]) {
      const auto slope = load<VR>(planes.slope[which] + first);
      const auto offset = load<VR>(planes.offset[which] + first);
      const auto over = [&](int c) {
        return mul_sub(slope, set<VR>(z_[c][lane]), set<VR>(q[c][lane]));
      };
      if (which == 1) {
        const auto best = max(max(over(0), over(1)), over(2));
        return best + offset >= slack;
      }
      const auto best = min(min(over(0), over(1)), over(2));
      return best + offset <= -slack;
    };
    auto keep = load<VR>(rays_.row_far + first) >= z_low_[lane];
    keep = keep && (meets(rays_.row_u, 0, x_) && meets(rays_.row_u, 1, x_));
    keep = keep && (meets(rays_.row_v, 0, y_) && meets(rays_.row_v, 1, y_));
    rows |= uint64_t{bits_of<VR>(keep)} << first;
  }
  return rows;
}

template <int W, bool kAny>
bool BundleBlock<W, kAny>::test_row(const TriangleBlock<W>& block, size_t lane, size_t row,
                                    const Plane& plane) {
  TESSERA_COUNT(row_tests, 1);
  const size_t at = row * kLanes;
  V x[3], y[3], size = set<V>(0);
  const V shear_x = load<V>(rays_.shear_x + at), shear_y = load<V>(rays_.shear_y + at);
  for (int c = 0; c < 3; ++c) {
    const auto from = [&](int axis) {
      return block.vertex[3 * c + axis][lane] - load<V>(rays_.from[axis] + at);
    };
    const V z = from(rays_.kz);
    x[c] = neg_mul_add(shear_x, z, from(rays_.kx));
    y[c] = neg_mul_add(shear_y, z, from(rays_.ky));
    size = max(size, max(abs(x[c]), abs(y[c])));
  }
  const auto edge = [&](int c, int e) { return mul_sub(x[c], y[e], y[c] * x[e]); };
  const V e0 = edge(0, 1), e1 = edge(1, 2), e2 = edge(2, 0);
  const float per_size = kEdgeTolerance * (size_[lane] + rays_.reach);
  const V tolerance = mul_add(size, set<V>(per_size), set<V>(kUnderflow));
  const V below = -tolerance;
  const V least = min(min(e0, e1), e2), greatest = max(max(e0, e1), e2);
  const M is_possible = least >= below || greatest <= tolerance;
  if (is_none<V>(is_possible)) return false;

  TESSERA_COUNT(times, 1);
  const V distance = distance_of(block, lane, at, plane);
  const V speed = speed_of(rays_, plane, at);
  const V t = distance / speed;
  const V slowest = static_cast<float>(plane.least) * load<V>(rays_.length + at) + kPlaneLeast;
  M counts = abs(speed) >= slowest;
  counts = counts && abs(distance) >= kPlaneLeast;
  counts = counts && abs(distance) <= 1 / kPlaneLeast;
  const M is_inside = least > tolerance || greatest < below;
  bool has_hit = false;
  uint32_t open = rays_.template take<kAny>(
      row, {t, counts, is_possible, counts && is_inside, load<V>(rays_.t_min + at)},
      block.primitive[lane], has_hit);
  if (HWY_UNLIKELY(__builtin_popcount(open) > kFew)) open &= ~elsewhere(block, lane, at);
  for (; open != 0; open &= open - 1)
    has_hit |= decide(block, lane, at + static_cast<size_t>(__builtin_ctz(open)));
  return has_hit;
}

// N.(A - O) of a row, by the operations of plane_of(); NaN where it does not count.
template <int W, bool kAny>
typename BundleBlock<W, kAny>::V BundleBlock<W, kAny>::distance_of(const TriangleBlock<W>& block,
                                                                   size_t lane, size_t at,
                                                                   const Plane& plane) const {
  const auto distance = [&](size_t first) {
    const auto to = [&](size_t axis) {
      return static_cast<double>(block.vertex[axis][lane]) - in_double(rays_.from[axis] + first);
    };
    const auto x = to(0), y = to(1), z = to(2);
    const auto sum = plane.normal[0] * x + plane.normal[1] * y + plane.normal[2] * z;
    const auto size = abs(x) + abs(y) + abs(z);
    const auto is_good = abs(sum) >= plane.least * size;
    return convert<FloatOf<Doubles>>(select(is_good, sum, set<Doubles>(__builtin_nan(""))));
  };
  return halves(D(), [&](size_t half) { return distance(at + half * kLanes / 2); });
}

// Returns: bits of rays, from `at` on, that surely miss a triangle.
template <int W, bool kAny>
uint32_t BundleBlock<W, kAny>::elsewhere(const TriangleBlock<W>& block, size_t lane,
                                         size_t at) const {
  uint32_t found = 0;
  for (size_t first = 0; first < kLanes; first += kLanesOf<Doubles>) {
    const auto corner = [&](size_t k) HWY_ATTR {
      return set<Doubles>(static_cast<double>(block.vertex[k][lane]));
    };
    const auto of = [&](const auto& v) {
      return [&](size_t k) HWY_ATTR { return in_double(v[k] + at + first); };
    };
    const auto out = is_elsewhere(corner, of(rays_.from), of(rays_.direction));
    found |= uint32_t{bits_of<Doubles>(out)} << first;
  }
  return found;
}

// Decides one ray that the filter leaves open.
template <int W, bool kAny>
bool BundleBlock<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, size_t ray) {
  TESSERA_COUNT(exact, 1);
  float triangle[9], origin[3], direction[3];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  for (size_t k = 0; k < 3; ++k) {
    origin[k] = rays_.from[k][ray];
    direction[k] = rays_.direction[k][ray];
  }
  float speed = 0, t = 0;
  if (plane_t(plane_of(block, lane, origin), direction, rays_.length[ray], speed, t)) {
    if (!is_exact_hit(origin, direction, triangle)) return false;
  } else {
    const ExactHit exact = exact_hit(origin, direction, triangle);
    if (!exact.is_hit) return false;
    t = exact.t;
  }
  return rays_.template take<kAny>(ray, t, rays_.t_min[ray], block.primitive[lane]);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
