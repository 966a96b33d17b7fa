// One ray and the triangles of a block, all at once: what single rays do in every structure.
//
// Triangles. As in triangle_fan-inl.h: the signs of three edge functions where they are sure,
// exact_hit() where not. Here the triangle is sheared so that the ray is the z axis, after Woop,
// Benthin, Wald, 2013. With s the largest coordinate of a corner from the origin and M the largest
// across the ray, after the shear, an edge function is off by at most
//    2 u M M    one product and the fused difference
//   12 u s D    corners, off by 4 u s per axis (moved, shear of two roundings, fused): the ray's distance
//               from an edge of extent D <= 2 M is known to 6 u s
// whatever the ray, and a ray that is outside of one edge by more is outside the triangle,
// whichever way the triangle is turned (see triangle_fan-inl.h). M <= 2 s. So 32 u s M is enough for
// all three, with s bounded by the whole scene.
//
// Where a line surely passes through, its t is that of the corners weighed by the edge functions.
// Each weight is off by 2 tolerances of the sum of the three at most, all of them by 6, so t is
// known to that part of what the corners' t differ by, and to the roundings. That rules triangles
// out, and is all that any-hit needs, before plane-inl.h says what t is.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#undef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_RAY_INL_H_
#endif

#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/simd/counts_layout.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Of an edge function, per largest coordinate of a corner from the origin and per largest across
// the ray; see above.
constexpr float kEdgeTolerance = 33 * kRoundoff;

template <int W, bool kAny>
class RayState {
 public:
  float t() const { return best_t_; }
  int32_t primitive() const { return best_; }

 protected:
  using B = hn::CappedTag<float, W>;  // children, triangles
  using V = hn::Vec<B>;
  using M = hn::Mask<B>;
  static constexpr size_t kStep = hn::MaxLanes(B());

  // Returns: whether the ray is valid.
  HWY_INLINE bool setup(const SingleRay& ray, const SceneBox& scene);
  HWY_INLINE void test_block(const TriangleBlock<W>& block);

  bool is_down(int axis) const { return (down_ >> axis & 1u) != 0; }

  using A = hn::CappedTag<float, 4>;  // axes; the fourth is 0
  static constexpr size_t kAxisStep = hn::MaxLanes(A());
  alignas(16) float origin_[4], direction_[4];
  alignas(16) float slope_[4];    // the direction, scaled by a power of two where it is extreme
  alignas(16) float inverse_[4];  // of the slope
  alignas(16) float pad_[4];      // of t, where the ray hardly moves along an axis
  uint32_t down_ = 0;             // bits of the axes with a negative slope
  float near_limit_ = 0, far_limit_ = 0;  // of t, scaled and moved out
  int32_t best_ = -1;

 private:
  // Of a block's triangles, by bits.
  struct Candidates {
    uint32_t possible;  // the line may pass through within the limits of t
    uint32_t sure;      // it does pass through
    uint32_t certain;   // it does so within the limits; for any-hit only
  };

  HWY_INLINE void scale(float largest, float reach);
  HWY_INLINE void invert(float largest, float reach);
  HWY_INLINE Candidates candidates(const TriangleBlock<W>& block, size_t first) const;
  HWY_INLINE void narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low, V& high) const;
  HWY_INLINE void test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure);
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, float& exact_t) const;
  HWY_INLINE void accept(float t, int32_t primitive);

  float tolerance_ = 0;  // of an edge function per size of its triangle across the ray
  float scale_ = 1;      // scaled t = t * scale_
  float size_ = 0;       // sum of |direction|
  int kx_ = 0, ky_ = 1, kz_ = 2;
  float t_min_ = 0, best_t_ = 0;
  int32_t unmet_[2] = {-1, -1};
};

HWY_INLINE float moved(float t, float share) { return t + abs_of(t) * share; }

template <int W, bool kAny>
bool RayState<W, kAny>::setup(const SingleRay& ray, const SceneBox& scene) {
  const A d;
  auto far = hn::Zero(d), longest = far, reached = far;
  for (size_t a = 0; a < 4; a += kAxisStep) {
    // The number behind each of the two arrays is one of the ray's, too.
    const auto is_axis = hn::FirstN(d, 3 - a);
    const auto from = hn::IfThenElseZero(is_axis, hn::LoadU(d, ray.origin + a));
    const auto along = hn::IfThenElseZero(is_axis, hn::LoadU(d, ray.direction + a));
    hn::Store(from, d, origin_ + a);
    hn::Store(along, d, direction_ + a);
    far = hn::Add(far, hn::Abs(from));
    longest = hn::Max(longest, hn::Abs(along));
    const auto low = hn::Abs(hn::Sub(hn::Load(d, scene.lower + a), from));
    const auto high = hn::Abs(hn::Sub(hn::Load(d, scene.upper + a), from));
    reached = hn::Max(reached, hn::Max(low, high));
  }
  const float infinity = __builtin_inff();
  size_ = (abs_of(direction_[0]) + abs_of(direction_[1])) + abs_of(direction_[2]);
  if (!(size_ > 0 && size_ < infinity && ray.t_min <= ray.t_max)) return false;
  if (!hn::AllTrue(d, hn::Lt(far, hn::Inf(d)))) return false;
  const auto most = hn::MaxOfLanes(d, longest);
  const float largest = hn::GetLane(most);
  const float reach = hn::GetLane(hn::MaxOfLanes(d, reached));
  uint32_t is_main = 0;
  for (size_t a = 0; a < 4; a += kAxisStep)
    is_main |= bits_of(d, hn::Eq(hn::Abs(hn::Load(d, direction_ + a)), most)) << a;
  kz_ = __builtin_ctz(is_main);
  kx_ = kz_ == 2 ? 0 : kz_ + 1;
  ky_ = kz_ == 0 ? 2 : kz_ - 1;
  scale(largest, reach);
  invert(abs_of(slope_[kz_]), reach);
  tolerance_ = kEdgeTolerance * reach;
  t_min_ = ray.t_min;
  for (int k = 0; k < 2; ++k) unmet_[k] = static_cast<int32_t>(ray.unmet[k]);
  best_t_ = ray.t_max;
  best_ = -1;
  near_limit_ = moved(t_min_ * scale_, -kTimeSlack);
  far_limit_ = moved(best_t_ * scale_, kTimeSlack);
  return true;
}

// So that no product of a coordinate with an inverse overflows, which is at most 2^60 for
// coordinates below 2^60 and at most 1 beyond.
template <int W, bool kAny>
void RayState<W, kAny>::scale(float largest, float reach) {
  const A d;
  for (size_t a = 0; a < 4; a += kAxisStep) hn::Store(hn::Load(d, direction_ + a), d, slope_ + a);
  const float wanted = reach < 0x1p60f ? 1.0f : 0x1p60f;
  scale_ = 1;
  if (HWY_LIKELY(largest > wanted * 0x1p-20f && largest < wanted * 0x1p20f)) return;
  while (!(largest >= wanted && largest < 2 * wanted)) {
    const float factor = largest < wanted ? 2 : 0.5f;
    for (float& s : slope_) s *= factor;
    largest *= factor;
    scale_ /= factor;
  }
}

// An axis along which the ray hardly moves counts as steeper than it is. The ray leaves the scene
// within t = reach / largest (twice that with all roundings), so it moves by less than `least`
// times that along it.
template <int W, bool kAny>
void RayState<W, kAny>::invert(float largest, float reach) {
  const A d;
  const auto least = hn::Set(d, largest * 0x1p-40f), widest = hn::Set(d, 4 * (reach / largest));
  down_ = 0;
  for (size_t a = 0; a < 4; a += kAxisStep) {
    auto slope = hn::Load(d, slope_ + a);
    const auto is_flat = hn::Lt(hn::Abs(slope), least);
    slope = hn::IfThenElse(is_flat, hn::CopySign(least, slope), slope);
    hn::Store(hn::IfThenElseZero(is_flat, widest), d, pad_ + a);
    hn::Store(hn::Div(hn::Set(d, 1), slope), d, inverse_ + a);
    down_ |= bits_of(d, hn::Lt(slope, hn::Zero(d))) << a;
  }
}

template <int W, bool kAny>
typename RayState<W, kAny>::Candidates RayState<W, kAny>::candidates(const TriangleBlock<W>& block,
                                                                     size_t first) const {
  const B b;
  V x[3], y[3], t[3], size = hn::Zero(b);
  for (int c = 0; c < 3; ++c) {
    // From the corner to the origin, which saves loading it; the edge functions are the same.
    const auto back = [&](int axis) {
      return hn::Sub(hn::Set(b, origin_[axis]), hn::Load(b, block.vertex[3 * c + axis] + first));
    };
    t[c] = hn::Mul(back(kz_), hn::Set(b, -inverse_[kz_]));
    x[c] = hn::MulAdd(hn::Set(b, slope_[kx_]), t[c], back(kx_));
    y[c] = hn::MulAdd(hn::Set(b, slope_[ky_]), t[c], back(ky_));
    size = hn::Max(size, hn::Max(hn::Abs(x[c]), hn::Abs(y[c])));
  }
  const auto edge_of = [&](int c, int e) { return hn::MulSub(x[c], y[e], hn::Mul(y[c], x[e])); };
  const V edge[3] = {edge_of(1, 2), edge_of(2, 0), edge_of(0, 1)};
  const V tolerance = hn::MulAdd(size, hn::Set(b, tolerance_), hn::Set(b, kUnderflow));
  const V least = hn::Min(hn::Min(edge[0], edge[1]), edge[2]);
  const V greatest = hn::Max(hn::Max(edge[0], edge[1]), edge[2]);
  const V depth =
      hn::Max(least, hn::Neg(greatest));  // how far inside, whichever side faces the ray
  M is_possible = hn::Ge(depth, hn::Neg(tolerance));
  if (kAny) {
    const hn::RebindToSigned<B> bi;
    const auto number = hn::Load(bi, reinterpret_cast<const int32_t*>(block.primitive) + first);
    const auto is_other = [&](int32_t unmet) { return hn::Ne(number, hn::Set(bi, unmet)); };
    const auto is_met = hn::And(is_other(unmet_[0]), is_other(unmet_[1]));
    is_possible = hn::And(is_possible, hn::RebindMask(b, is_met));
  }
  if (hn::AllFalse(b, is_possible)) return {0, 0, 0};

  const M is_sure = hn::And(is_possible, hn::Gt(depth, tolerance));
  V low = hn::Min(hn::Min(t[0], t[1]), t[2]), high = hn::Max(hn::Max(t[0], t[1]), t[2]);
  if (kAny) narrow(edge, t, tolerance, is_sure, low, high);
  const M is_near =
      hn::And(hn::Le(low, hn::Set(b, far_limit_)), hn::Ge(high, hn::Set(b, near_limit_)));
  Candidates found{bits_of(b, hn::And(is_possible, is_near)), bits_of(b, is_sure), 0};
  if (kAny) {
    const V inner_near = hn::Set(b, moved(near_limit_, 2 * kTimeSlack));
    const V inner_far = hn::Set(b, moved(far_limit_, -2 * kTimeSlack));
    const M is_within = hn::And(hn::Gt(low, inner_near), hn::Lt(high, inner_far));
    found.certain = found.sure & bits_of(b, is_within);
  }
  return found;
}

// Where between its corners the line meets a triangle, as far as is known; t [3]: of the corners.
// Roundings are 10 u of the largest of these, which is no more than t itself and what they differ
// by: the limits have been moved by 16 u of the one, the interval is by 16 u of the other.
template <int W, bool kAny>
void RayState<W, kAny>::narrow(const V* edge, const V* t, V tolerance, M is_sure, V& low,
                               V& high) const {
  const B b;
  const V per_sum = hn::Div(hn::Set(b, 1), hn::Add(hn::Add(edge[0], edge[1]), edge[2]));
  const auto weight = [&](int c) {
    return hn::Mul(edge[c], per_sum);
  };  // t times an edge may overflow
  const V middle =
      hn::MulAdd(weight(0), t[0], hn::MulAdd(weight(1), t[1], hn::Mul(weight(2), t[2])));
  const V off = hn::Mul(tolerance, hn::Set(b, 8));
  const V share = hn::MulAdd(hn::Abs(per_sum), off, hn::Set(b, 16 * kRoundoff));
  const V spread = hn::Mul(hn::Sub(high, low), share);
  low = hn::IfThenElse(is_sure, hn::Sub(middle, spread), low);
  high = hn::IfThenElse(is_sure, hn::Add(middle, spread), high);
}

template <int W, bool kAny>
void RayState<W, kAny>::test_block(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  for (size_t first = 0; first < W; first += kStep) {
    const Candidates found = candidates(block, first);
    if (kAny && found.certain != 0) {
      const auto lane = first + static_cast<size_t>(__builtin_ctz(found.certain));
      return accept(best_t_, static_cast<int32_t>(block.primitive[lane]));
    }
    for (uint32_t bits = found.possible; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      test_triangle(block, first + lane, found.sure >> lane & 1u);
    }
  }
}

// A triangle that candidates() leaves open.
template <int W, bool kAny>
bool RayState<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, float& exact_t) const {
  TESSERA_COUNT(exact, 1);
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  const ExactHit exact = exact_hit(origin_, direction_, triangle);
  exact_t = exact.t;
  return exact.is_hit;
}

template <int W, bool kAny>
void RayState<W, kAny>::test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure) {
  TESSERA_COUNT(candidates, 1);
  const Plane plane = plane_of(block, lane, origin_);
  float t = 0, speed = 0;
  const bool counts = plane_t(plane, direction_, size_, speed, t);
  const auto number = static_cast<int32_t>(block.primitive[lane]);
  const bool is_lower = best_ == -1 || number < best_;
  const auto in_range = [&] { return t >= t_min_ && (t < best_t_ || (t == best_t_ && is_lower)); };
  if (counts && !in_range()) return;
  if (!counts || !is_sure) {
    float exact_t = 0;
    if (!decide(block, lane, exact_t)) return;
    if (!counts) t = exact_t;
    if (!in_range()) return;
  }
  accept(t, number);
}

template <int W, bool kAny>
void RayState<W, kAny>::accept(float t, int32_t primitive) {
  best_t_ = kAny ? -__builtin_inff() : t;
  best_ = primitive;
  far_limit_ = moved(best_t_ * scale_, kTimeSlack);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
