// One ray and the triangles of a block, all at once: what single rays do in every structure.
//
// Triangles. As in fan_block-inl.h: the signs of three edge functions where they are sure, exact_hit()
// where not. Here the triangle is sheared so that the ray is the z axis, after Woop, Benthin, Wald,
// 2013. With s the largest coordinate of a corner from the origin and M the largest across the ray,
// after the shear, an edge function is off by at most
//    2 u M M    one product and the fused difference
//   12 u s D    corners, off by 4 u s per axis (moved, shear of two roundings, fused): the ray's distance
//               from an edge of extent D <= 2 M is known to 6 u s
// whatever the ray, and a ray that is outside of one edge by more is outside the triangle, whichever
// way the triangle is turned (see fan_block-inl.h). M <= 2 s. So 32 u s M is enough for all three, with s
// bounded by the whole scene.
//
// Threads. One traversal owns one.
#include "slave/core/geometry/exact_hit_abi.h"
#include "slave/core/kernel/packet_layout.h"

#if defined(TESSERA_CORE_RAY_STATE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_RAY_STATE_INL_H_
#undef TESSERA_CORE_RAY_STATE_INL_H_
#else
#define TESSERA_CORE_RAY_STATE_INL_H_
#endif

#include "slave/core/kernel/counts_layout.h"
#include "slave/core/kernel/plane-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Of an edge function, per largest coordinate of a corner from the origin and per largest across the
// ray; see above.
constexpr float kEdgeTolerance = 33 * kRoundoff;

template <int W, bool kAny>
class RayState {
 public:
  float t() const { return best_t_; }
  int32_t primitive() const { return best_; }

 protected:
  using B = hn::CappedTag<float, W>;  // children, triangles
  using V = hn::Vec<B>;
  static constexpr size_t kStep = hn::MaxLanes(B());

  // lower, upper: of the scene. Returns: whether the ray is valid.
  HWY_INLINE bool setup(const SingleRay& ray, const float* lower, const float* upper);
  HWY_INLINE void test_block(const TriangleBlock<W>& block);

  float origin_[3], direction_[3];
  float inverse_[3];  // of the direction, scaled by a power of two where it is extreme
  float pad_[3];      // of t, where the ray hardly moves along an axis
  bool is_down_[3];   // the direction is negative
  float near_limit_ = 0, far_limit_ = 0;  // of t, scaled and moved out
  int32_t best_ = -1;

 private:
  HWY_INLINE void setup_axis(int axis, float slope, float largest, float reach);
  HWY_INLINE void limit();  // after t_min_ or best_t_ have changed
  HWY_INLINE uint32_t candidates(const TriangleBlock<W>& block, size_t first, uint32_t& sure) const;
  HWY_INLINE void test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure);
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, float& exact_t) const;

  float shear_x_ = 0, shear_y_ = 0;
  float tolerance_ = 0;  // of an edge function per size of its triangle across the ray
  float scale_ = 1;      // scaled t = t * scale_
  float size_ = 0;       // sum of |direction|
  int kx_ = 0, ky_ = 1, kz_ = 2;
  float t_min_ = 0, best_t_ = 0;
};

template <int W, bool kAny>
bool RayState<W, kAny>::setup(const SingleRay& ray, const float* lower, const float* upper) {
  float largest = 0, reach = 0, slope[3];
  size_ = 0;
  for (int a = 0; a < 3; ++a) {
    origin_[a] = ray.origin[a];
    slope[a] = direction_[a] = ray.direction[a];
    const float length = abs_of(ray.direction[a]);
    if (!(length < __builtin_inff()) || !(abs_of(ray.origin[a]) < __builtin_inff())) return false;
    if (length > largest) {
      largest = length;
      kz_ = a;
    }
    size_ += length;
    const float low = lower[a] - ray.origin[a], high = upper[a] - ray.origin[a];
    reach = max_of(reach, max_of(abs_of(low), abs_of(high)));
  }
  if (!(largest > 0) || !(ray.t_min <= ray.t_max)) return false;
  kx_ = (kz_ + 1) % 3;
  ky_ = (kz_ + 2) % 3;
  t_min_ = ray.t_min;
  best_t_ = ray.t_max;
  best_ = -1;
  const bool is_extreme = !(largest > 0x1p-60f && largest < 0x1p60f);
  scale_ = 1;
  while (is_extreme && !(largest >= 1 && largest < 2)) {
    const float factor = largest < 1 ? 2 : 0.5f;
    for (float& s : slope) s *= factor;
    largest *= factor;
    scale_ /= factor;
  }
  for (int a = 0; a < 3; ++a) setup_axis(a, slope[a], largest, reach);
  tolerance_ = kEdgeTolerance * reach;
  shear_x_ = slope[kx_] * inverse_[kz_];
  shear_y_ = slope[ky_] * inverse_[kz_];
  limit();
  return true;
}

template <int W, bool kAny>
void RayState<W, kAny>::setup_axis(int axis, float slope, float largest, float reach) {
  const float least = largest * 0x1p-60f;
  const bool is_flat = abs_of(slope) < least;
  if (is_flat) slope = direction_[axis] < 0 ? -least : least;
  inverse_[axis] = 1 / slope;
  // The ray leaves the scene within t = reach / largest (twice that with all roundings), so it
  // moves by less than `least` times that along this axis.
  pad_[axis] = is_flat ? 4 * (reach / largest) : 0;
  is_down_[axis] = slope < 0;
}

template <int W, bool kAny>
void RayState<W, kAny>::limit() {
  const auto widened = [](float t, float sign) { return t + sign * abs_of(t) * kTimeSlack; };
  near_limit_ = widened(t_min_ * scale_, -1);
  far_limit_ = widened(best_t_ * scale_, 1);
}

// Triangles that the line may pass through; sure: those that it does.
template <int W, bool kAny>
uint32_t RayState<W, kAny>::candidates(const TriangleBlock<W>& block, size_t first,
                                       uint32_t& sure) const {
  const B b;
  V x[3], y[3], size = hn::Zero(b);
  for (int c = 0; c < 3; ++c) {
    const auto at = [&](int axis) {
      const V corner = hn::Load(b, block.vertex[3 * c + axis] + first);
      return hn::Sub(corner, hn::Set(b, origin_[axis]));
    };
    const V z = at(kz_);
    x[c] = hn::NegMulAdd(hn::Set(b, shear_x_), z, at(kx_));
    y[c] = hn::NegMulAdd(hn::Set(b, shear_y_), z, at(ky_));
    size = hn::Max(size, hn::Max(hn::Abs(x[c]), hn::Abs(y[c])));
  }
  const auto edge = [&](int c, int e) { return hn::MulSub(x[c], y[e], hn::Mul(y[c], x[e])); };
  const V e0 = edge(0, 1), e1 = edge(1, 2), e2 = edge(2, 0);
  const V tolerance = hn::MulAdd(size, hn::Set(b, tolerance_), hn::Set(b, kUnderflow));
  const V least = hn::Min(hn::Min(e0, e1), e2), greatest = hn::Max(hn::Max(e0, e1), e2);
  const V below = hn::Neg(tolerance);
  sure = bits_of(b, hn::Or(hn::Gt(least, tolerance), hn::Lt(greatest, below)));
  return bits_of(b, hn::Or(hn::Ge(least, below), hn::Le(greatest, tolerance)));
}

template <int W, bool kAny>
void RayState<W, kAny>::test_block(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  for (size_t first = 0; first < W; first += kStep) {
    uint32_t sure = 0;
    for (uint32_t bits = candidates(block, first, sure); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      test_triangle(block, first + lane, sure >> lane & 1u);
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
  best_t_ = kAny ? -__builtin_inff() : t;
  best_ = number;
  limit();
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
