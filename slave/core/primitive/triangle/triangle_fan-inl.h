// SPDX-License-Identifier: Apache-2.0
// The triangles of a block against a fan: culled by the frustum before any ray sees them.
//
// Decisions. A ray meets a triangle A, B, C where it passes its three edges on one side. The side
// is the sign of E = d . ((A + B) x (B - A)) = 2 d . (A x B). E is computed in float32, over the
// length D of its edge, so that one tolerance serves for all three, and
//    E < -tol for one edge    surely outside,
//    E >  tol for all three   surely inside,
//     else                     exact_hit() decides, which is exact.
// A triangle is therefore hit by the rays that hit it in exact arithmetic, whatever the rounding
// here, and fused multiply-adds may be used for E. What is reported, t, is computed without them,
// by the same operations in every kernel (plane-inl.h), once for each ray.
//
// Tolerances, and how far a nearness may be off, are derived in fan_forms-inl.h.
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

#include "slave/core/primitive/triangle/edge_sides-inl.h"
#include "slave/core/primitive/triangle/fan_forms-inl.h"
#include "slave/core/primitive/triangle/fan_winners-inl.h"
#include "slave/core/ray/twin_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Rays: FanRays, or TwinRays, whose fans are tested one after the other.
template <int W, bool kAny, class Rays>
class FanBlockOf {
  using V = FanRays::V;  // rays
  using VI = FanRays::VI;
  using M = FanRays::M;
  using VB = FloatsOf<W>;  // triangles
  using MB = MaskOf<VB>;
  using Tests = FrustumTriangles<W>;
  using Forms = FanForms<W, Rays>;
  static constexpr size_t kLanes = FanRays::kLanes;
  static constexpr size_t kRows = FanRays::kRows;
  static constexpr size_t kStep = kLanesOf<VB>;

 public:
  static constexpr bool kIsAny = kAny;
  static_assert(kAny || Rays::kFans == 1);
  explicit FanBlockOf(Rays& rays)
      : rays_(rays), fan_at_(&rays.fan(0)), forms_(rays), winners_(rays.fan(0)) {}

  // Requires, before tests: the rays are set up.
  HWY_INLINE void prepare() {
    forms_.prepare();
    winners_.clear();
    planes_.spread(rays_);
  }

  // Returns: whether some ray has a new best hit.
  bool test(const TriangleBlock<W>& block);
  // Finds t of a ray's best hit where that was put off.
  HWY_INLINE void settle(size_t ray) { winners_.settle(ray); }
  // To be called after all tests: finds t of what was hit.
  void finish() { winners_.settle_all(); }

 private:
  // What the test of a row of rays against a triangle finds.
  struct Met {
    V near;
    M is_possible, is_sure;
  };
  HWY_INLINE typename Forms::Kept cull(const TriangleBlock<W>& block, size_t first);
  HWY_NOINLINE bool test_unsure(const TriangleBlock<W>& block, size_t lane);
  template <bool kCareful>
  HWY_INLINE bool test_rays(const TriangleBlock<W>& block, size_t lane, uint64_t rows);
  // A form of a triangle, for the rays of the row that begins at `at`.
  HWY_INLINE V value(const float (*form)[W], size_t lane, size_t at) const {
    const V u = load<V>(fan().ray_u + at), v = load<V>(fan().ray_v + at);
    return mul_add(u, set<V>(form[0][lane]),
                   mul_add(v, set<V>(form[1][lane]), set<V>(form[2][lane])));
  }
  template <bool kCareful, class Edges>
  HWY_INLINE Met test_row(const Edges& edges, size_t lane, size_t row) const;
  template <bool kCareful, size_t kFirst>
  HWY_INLINE uint64_t test_rows_straight(const TriangleBlock<W>& block, size_t lane, bool& has_hit);
  HWY_INLINE uint64_t take(const TriangleBlock<W>& block, size_t lane, size_t row, const Met& met,
                           int32_t slot);
  HWY_NOINLINE bool test_close(const TriangleBlock<W>& block, size_t lane) {
    return test_fans<true>(block, lane, forms_.rows_of(lane));
  }
  // Decides those of the open rays that are surely inside of the triangle, by their t, and takes
  // them out of `open`. Returns: whether some ray has a new best hit.
  HWY_NOINLINE bool compare_times(const TriangleBlock<W>& block, size_t lane, uint64_t& open);
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, uint64_t rays);

  // The fan that is tested.
  HWY_INLINE FanRays& fan() const {
    if constexpr (Rays::kFans == 1) {
      return rays_.fan(0);
    } else {
      return *fan_at_;
    }
  }
  // Tests the rays of each fan, in turn.
  template <bool kCareful>
  HWY_INLINE bool test_fans(const TriangleBlock<W>& block, size_t lane, uint64_t rows) {
    bool has_hit = false;
    for (size_t f = 0; f < Rays::kFans; ++f) {
      if (Rays::kFans > 1) fan_at_ = &rays_.fan(f);
      has_hit |= test_rays<kCareful>(block, lane, rows);
    }
    return has_hit;
  }
  // Decides all rays of each fan.
  bool decide_all(const TriangleBlock<W>& block, size_t lane) {
    bool has_hit = false;
    for (size_t f = 0; f < Rays::kFans; ++f) {
      fan_at_ = &rays_.fan(f);
      has_hit |= decide(block, lane, ~uint64_t{0});
    }
    return has_hit;
  }

  // Planes of fans that look for any hit are narrowed on the way.
  static constexpr bool kSpreadsPlanes = !kAny && FanRays::kHasManyRows;
  HWY_INLINE const auto& planes() const {
    if constexpr (kSpreadsPlanes) {
      return planes_;
    } else {
      return rays_;
    }
  }

  Rays& rays_;
  FanRays* fan_at_;  // see fan()
  Forms forms_;      // of the block that is being tested
  FanWinners<W> winners_;
  [[no_unique_address]] PlanesOf<VB, kSpreadsPlanes> planes_;
};

template <int W, bool kAny, class Rays>
typename FanForms<W, Rays>::Kept FanBlockOf<W, kAny, Rays>::cull(const TriangleBlock<W>& block,
                                                                 size_t first) {
  const Corners<VB> p = Tests::corners(rays_, block, first);
  MB keep = Tests::triangles(rays_, planes(), p);
  if (kAny) {
    using VN = IntOf<VB>;
    const auto number = load<VN>(reinterpret_cast<const int32_t*>(block.primitive) + first);
    keep = keep && mask_as<VB>(number != rays_.excluded);
  }
  if (is_none<VB>(keep)) return {};
  return forms_.look_at(planes(), block, first, p, keep);
}

template <int W, bool kAny, class Rays>
bool FanBlockOf<W, kAny, Rays>::test(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  bool has_hit = false;
  for (size_t first = 0; first < W; first += kStep) {
    const auto kept = cull(block, first);
    for (uint32_t bits = kept.met; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      TESSERA_COUNT(candidates, 1);
      if ((kept.unsure >> lane & 1u) != 0) {
        has_hit |= test_unsure(block, lane);
      } else if ((kept.close >> lane & 1u) != 0) {
        has_hit |= test_close(block, lane);
      } else {
        const uint64_t rows = forms_.rows_of(lane);
        // Where rows are not culled, `rows` is 0: all rays at once cost no more than culling does.
        rays_.work_left -= 2 * static_cast<int>(Rays::kFans) + __builtin_popcountll(rows);
        if (Forms::kCullsRows && rows == 0) continue;
        has_hit |= test_fans<false>(block, lane, rows);
      }
    }
  }
  return has_hit;
}

// Tests a triangle for which it is not sure on which side of its plane the origin lies.
template <int W, bool kAny, class Rays>
bool FanBlockOf<W, kAny, Rays>::test_unsure(const TriangleBlock<W>& block, size_t lane) {
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  if (!has_area(triangle)) return false;
  const int side = exact_side(rays_.origin, triangle);
  if (side == 0)  // only rays that start in the triangle can touch it
    return decide_all(block, lane);
  const bool is_behind = static_cast<float>(side) * rays_.side < 0;
  const bool is_right = is_behind == (__builtin_signbit(forms_.sides[lane]) != 0);
  const uint64_t rows = forms_.rows_of(lane);  // with the orientation as computed
  forms_.turn(lane);
  const uint64_t other_rows = forms_.rows_of(lane);
  if (is_right) forms_.turn(lane);
  return test_fans<true>(block, lane, rows | other_rows);
}

// kCareful: the triangle's orientation is not sure, or it may lie before t_min.
template <int W, bool kAny, class Rays>
template <bool kCareful, class Edges>
typename FanBlockOf<W, kAny, Rays>::Met FanBlockOf<W, kAny, Rays>::test_row(const Edges& edges,
                                                                            size_t lane,
                                                                            size_t row) const {
  TESSERA_COUNT(row_tests, 1);
  const size_t at = row * kLanes;
  const auto edge = [&](size_t c) HWY_ATTR {
    return edges.value(c, load<V>(fan().ray_u + at), load<V>(fan().ray_v + at));
  };
  const V slack = set<V>(forms_.doubt[lane]), twice = set<V>(forms_.twice[lane]);
  const V e0 = edge(0), e1 = edge(1), e2 = edge(2);
  const V least = min(min(e0, e1), e2);
  const M is_inside = least >= 0;
  if (FanRays::kHasManyRows && !kCareful && is_none<V>(is_inside))
    return {least, is_inside, is_inside};
  const V near = value(forms_.nearness, lane, at);
  Met met{near, is_inside, least > twice};
  if (kCareful) {
    // A ray may also be inside of the reversed triangle, where it does not pass it steeply.
    const V most = max(max(e0, e1), e2);
    const M is_thick = abs(near) > set<V>(forms_.steep[lane]);
    met.is_possible = met.is_possible || and_not(is_thick, most <= twice);
    met.is_sure = met.is_sure && is_thick && near + slack < fan().nearest_min;
  }
  met.is_possible = met.is_possible && near + slack >= load<V>(fan().low + at);
  met.is_sure = met.is_possible && met.is_sure && near - slack > load<V>(fan().high + at);
  return met;
}

// Takes the hits that are sure. Returns: the bits of the rays that are to be decided.
template <int W, bool kAny, class Rays>
uint64_t FanBlockOf<W, kAny, Rays>::take(const TriangleBlock<W>& block, size_t lane, size_t row,
                                         const Met& met, int32_t slot) {
  const size_t at = row * kLanes;
  const V slack = set<V>(forms_.doubt[lane]);
  const auto put = [&](auto a, auto* to) HWY_ATTR { store_where(met.is_sure, a, to); };
  put(set<VI>(static_cast<int32_t>(block.primitive[lane])), fan().best + at);
  if (kAny) {
    put(set<V>(__builtin_inff()), fan().low + at);
    put(set<V>(__builtin_inff()), fan().high + at);
    put(set<V>(-__builtin_inff()), fan().best_t + at);
  } else {
    put(met.near - slack, fan().low + at);
    put(met.near + slack, fan().high + at);
    put(set<VI>(slot), fan().pending + at);
  }
  return uint64_t{bits_of<V>(and_not(met.is_sure, met.is_possible))} << at;
}

// Tests the first rows, without a branch between them. Returns: the bits of the rays that are to be
// decided.
template <int W, bool kAny, class Rays>
template <bool kCareful, size_t kFirst>
uint64_t FanBlockOf<W, kAny, Rays>::test_rows_straight(const TriangleBlock<W>& block, size_t lane,
                                                       bool& has_hit) {
  Met met[kFirst];
  const auto edges = forms_.edges_of(lane);
  for (size_t row = 0; row < kFirst; ++row) met[row] = test_row<kCareful>(edges, lane, row);
  M is_possible = met[0].is_possible, is_sure = met[0].is_sure;
  for (size_t row = 1; row < kFirst; ++row) {
    is_possible = is_possible || met[row].is_possible;
    is_sure = is_sure || met[row].is_sure;
  }
  if (is_none<V>(is_possible)) return 0;
  has_hit = !is_none<V>(is_sure);
  const int32_t slot = !kAny && has_hit ? winners_.add(block, lane) : -1;
  uint64_t open = 0;
  for (size_t row = 0; row < kFirst; ++row) open |= take(block, lane, row, met[row], slot);
  return open;
}

template <int W, bool kAny, class Rays>
template <bool kCareful>
bool FanBlockOf<W, kAny, Rays>::test_rays(const TriangleBlock<W>& block, size_t lane,
                                          uint64_t rows) {
  uint64_t open = 0;
  bool has_hit = false;
  if constexpr (Forms::kCullsRows) {
    int32_t slot = -1;
    const auto edges = forms_.edges_of(lane);
    for (; rows != 0; rows &= rows - 1) {
      const auto row = static_cast<size_t>(__builtin_ctzll(rows));
      const Met met = test_row<kCareful>(edges, lane, row);
      if (is_none<V>(met.is_possible)) continue;
      const bool is_any_sure = !is_none<V>(met.is_sure);
      if (!kAny && is_any_sure && slot < 0) slot = winners_.add(block, lane);
      has_hit |= is_any_sure;
      open |= take(block, lane, row, met, slot);
    }
  } else {
    open = fan().filled_rows <= 2 ? test_rows_straight<kCareful, 2>(block, lane, has_hit)
                                  : test_rows_straight<kCareful, kRows>(block, lane, has_hit);
  }
  if (HWY_UNLIKELY(open != 0)) {
    // Rays that have met this triangle before, in another leaf, need no decision.
    const auto number = static_cast<int32_t>(block.primitive[lane]);
    for (size_t at = 0; at < kPacketRays; at += kLanes)
      open &= ~(uint64_t{bits_of<VI>(load<VI>(fan().best + at) == number)} << at);
    if (kAny) open &= ~fan().ending_at(open, number);
    // Shadow fans have no two t to compare, and their directions do not lie in rows.
    if constexpr (!kAny && !kCareful) {
      if (open != 0) has_hit |= compare_times(block, lane, open);
    }
    if (open != 0) has_hit |= decide(block, lane, open);
  }
  return has_hit;
}

// Where surfaces coincide, all rays of a row that meet them are open.
template <int W, bool kAny, class Rays>
bool FanBlockOf<W, kAny, Rays>::compare_times(const TriangleBlock<W>& block, size_t lane,
                                              uint64_t& open) {
  const Plane plane = plane_of(block, lane, fan().origin);
  bool has_hit = false;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const M is_open = mask_of<V>(static_cast<uint32_t>(open >> at));
    if (is_none<V>(is_open)) continue;
    const auto edge = [&](int c) HWY_ATTR { return value(forms_.edges[c], lane, at); };
    const M is_inside = min(min(edge(0), edge(1)), edge(2)) > set<V>(forms_.twice[lane]);
    const V speed = speed_of(fan(), plane, at);
    const V least = set<V>(plane.steepness) * fan().length_at(at) + kPlaneLeast;
    const M rays = is_open && is_inside && abs(speed) >= least;
    if (is_none<V>(rays)) continue;
    open &= ~(uint64_t{bits_of<V>(rays)} << at);
    winners_.settle_rays(at, rays);
    const V t = set<V>(plane.distance) / speed;
    has_hit |= fan().take_rays(at, rays, t, static_cast<int32_t>(block.primitive[lane]));
  }
  return has_hit;
}

// Decides rays that the filter leaves open: in double, and exactly where that cannot tell.
template <int W, bool kAny, class Rays>
bool FanBlockOf<W, kAny, Rays>::decide(const TriangleBlock<W>& block, size_t lane, uint64_t rays) {
  constexpr size_t kTogether = EdgeSides::kRays;
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  if (!has_area(triangle)) return false;
  const EdgeSides sides(fan().origin, triangle);
  const Plane plane = plane_of(triangle, fan().origin);
  bool has_hit = false;
  for (rays &= fan().valid; rays != 0;) {
    size_t number[kTogether] = {};
    alignas(64) float directions[3][kTogether] = {};
    size_t count = 0;
    for (; rays != 0 && count < kTogether; rays &= rays - 1, ++count) {
      TESSERA_COUNT(exact, 1);
      number[count] = static_cast<size_t>(__builtin_ctzll(rays));
      float direction[3];
      fan().direction_of(number[count], direction);
      for (size_t k = 0; k < 3; ++k) directions[k][count] = direction[k];
    }
    const EdgeSides::Found found = sides.of(directions);
    for (size_t i = 0; i < count; ++i) {
      const float direction[3] = {directions[0][i], directions[1][i], directions[2][i]};
      const bool is_known = (found.known >> i & 1u) != 0;
      if (is_known ? (found.met >> i & 1u) == 0 : !is_exact_hit(fan().origin, direction, triangle))
        continue;
      float speed = 0, t = 0;
      if (!plane_t(plane, direction, FanRays::length_of(direction), speed, t))
        t = exact_hit(fan().origin, direction, triangle).t;
      if (!kAny) winners_.settle(number[i]);
      has_hit |= fan().template take<kAny>(number[i], t, fan().t_min, block.primitive[lane]);
    }
  }
  return has_hit;
}

template <int W, bool kAny>
using FanBlock = FanBlockOf<W, kAny, FanRays>;
template <int W, bool kAny>
using TwinBlock = FanBlockOf<W, kAny, TwinRays>;

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
