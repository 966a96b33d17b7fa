// Traversal of a wide hierarchy by one ray: all children of a node at once, all triangles of a
// block at once; closest and any hit. For rays that have no company: bounces, and packets that are
// none.
//
// After Wald, Benthin, Boulos, "Getting rid of packets", 2008, and Ize, "Robust BVH ray traversal",
// JCGT 2(2), 2013.
//
// Boxes. All distances to planes are relative to the origin before anything else, and rounding is
// monotonic, so their order is never wrong; what is left is relative: 1 u for the difference, 1 u
// for 1/d, 1 u for the product, and as much for the other side of the comparison. An axis along
// which the ray hardly moves (2^-60 of the largest) gets a steeper direction, and a padding for
// what the ray moves at all within the scene.
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
#include "slave/core/geometry/exact_hit_abi.h"
#include "slave/core/kernel/packet_layout.h"

#if defined(TESSERA_CORE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_RAY_INL_H_
#undef TESSERA_CORE_RAY_INL_H_
#else
#define TESSERA_CORE_RAY_INL_H_
#endif

#include "slave/core/kernel/node_stack-inl.h"
#include "slave/core/kernel/plane-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Of an edge function, per largest coordinate of a corner from the origin and per largest across the
// ray; see above.
constexpr float kEdgeTolerance = 33 * kRoundoff;

template <int W, bool kAny>
class RayTracer {
  using B = hn::CappedTag<float, W>;  // children, triangles
  using V = hn::Vec<B>;
  static constexpr size_t kStep = hn::MaxLanes(B());

 public:
  explicit RayTracer(const BvhView<W>& scene) : scene_(scene) {}

  // Returns: whether there is a hit.
  bool run(const SingleRay& ray);
  float t() const { return best_t_; }
  int32_t primitive() const { return best_; }

 private:
  HWY_INLINE bool setup(const SingleRay& ray);
  HWY_INLINE void setup_axis(int axis, float largest, float reach);
  HWY_INLINE void limit();  // after t_min_ or best_t_ have changed
  HWY_INLINE uint32_t overlapping(const BvhNode<W>& node, float* t_in) const;
  HWY_INLINE void test_block(const TriangleBlock<W>& block);
  HWY_INLINE uint32_t candidates(const TriangleBlock<W>& block, size_t first, uint32_t& sure) const;
  HWY_INLINE void test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure);
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, float& exact_t) const;

  const BvhView<W>& scene_;
  float origin_[3], direction_[3];
  float slope_[3];             // direction, scaled by a power of two where it is extreme
  float inverse_[3], pad_[3];  // of slope_
  bool is_down_[3];            // slope_ is negative
  float shear_x_ = 0, shear_y_ = 0;
  float tolerance_ = 0;  // of an edge function per size of its triangle across the ray
  float scale_ = 1;      // t of slope_ = t * scale_
  float size_ = 0;       // sum of |direction|
  int kx_ = 0, ky_ = 1, kz_ = 2;
  float t_min_ = 0, best_t_ = 0;
  float near_limit_ = 0, far_limit_ = 0;  // of slope_, moved out
  int32_t best_ = -1;
};

template <int W, bool kAny>
bool RayTracer<W, kAny>::setup(const SingleRay& ray) {
  float largest = 0, reach = 0;
  size_ = 0;
  for (int a = 0; a < 3; ++a) {
    origin_[a] = ray.origin[a];
    slope_[a] = direction_[a] = ray.direction[a];
    const float length = abs_of(ray.direction[a]);
    if (!(length < __builtin_inff()) || !(abs_of(ray.origin[a]) < __builtin_inff())) return false;
    if (length > largest) {
      largest = length;
      kz_ = a;
    }
    size_ += length;
    const float low = scene_.lower[a] - ray.origin[a], high = scene_.upper[a] - ray.origin[a];
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
    for (float& slope : slope_) slope *= factor;
    largest *= factor;
    scale_ /= factor;
  }
  for (int a = 0; a < 3; ++a) setup_axis(a, largest, reach);
  tolerance_ = kEdgeTolerance * reach;
  shear_x_ = slope_[kx_] * inverse_[kz_];
  shear_y_ = slope_[ky_] * inverse_[kz_];
  limit();
  return true;
}

template <int W, bool kAny>
void RayTracer<W, kAny>::setup_axis(int axis, float largest, float reach) {
  const float least = largest * 0x1p-60f;
  const bool is_flat = abs_of(slope_[axis]) < least;
  const float slope = is_flat ? (direction_[axis] < 0 ? -least : least) : slope_[axis];
  inverse_[axis] = 1 / slope;
  // The ray leaves the scene within t = reach / largest (twice that with all roundings), so it
  // moves by less than `least` times that along this axis.
  pad_[axis] = is_flat ? 4 * (reach / largest) : 0;
  is_down_[axis] = slope < 0;
}

template <int W, bool kAny>
void RayTracer<W, kAny>::limit() {
  const auto widened = [](float t, float sign) { return t + sign * abs_of(t) * kTimeSlack; };
  near_limit_ = widened(t_min_ * scale_, -1);
  far_limit_ = widened(best_t_ * scale_, 1);
}

template <int W, bool kAny>
uint32_t RayTracer<W, kAny>::overlapping(const BvhNode<W>& node, float* t_in) const {
  const B b;
  const float* in[3];
  const float* out[3];
  for (int a = 0; a < 3; ++a) {
    in[a] = is_down_[a] ? node.upper[a] : node.lower[a];
    out[a] = is_down_[a] ? node.lower[a] : node.upper[a];
  }
  TESSERA_COUNT(nodes, 1);
  uint32_t bits = 0;
  for (size_t i = 0; i < W; i += kStep) {
    const auto enter = [&](int a) {
      const V plane = hn::Sub(hn::Load(b, in[a] + i), hn::Set(b, origin_[a]));
      return hn::MulSub(plane, hn::Set(b, inverse_[a]), hn::Set(b, pad_[a]));
    };
    const auto leave = [&](int a) {
      const V plane = hn::Sub(hn::Load(b, out[a] + i), hn::Set(b, origin_[a]));
      return hn::MulAdd(plane, hn::Set(b, inverse_[a]), hn::Set(b, pad_[a]));
    };
    const V first = hn::Max(hn::Max(enter(0), enter(1)), enter(2));
    const V last = hn::Min(hn::Min(leave(0), leave(1)), leave(2));
    const V widest = hn::MulAdd(hn::Abs(last), hn::Set(b, 16 * kRoundoff), last);
    auto keep = hn::And(hn::Le(first, widest), hn::Ge(widest, hn::Set(b, near_limit_)));
    keep = hn::And(keep, hn::Le(first, hn::Set(b, far_limit_)));
    hn::Store(first, b, t_in + i);
    bits |= bits_of(b, keep) << i;
  }
  TESSERA_COUNT(children, __builtin_popcount(bits));
  return bits;
}

template <int W, bool kAny>
bool RayTracer<W, kAny>::run(const SingleRay& ray) {
  best_ = -1;
  if (!setup(ray)) return false;
  TESSERA_COUNT(singles, 1);
  alignas(64) float t_in[W];
  NodeStack<W> stack(scene_);
  while (!stack.is_empty()) {
    const StackEntry entry = stack.pop();
    if (entry.distance > far_limit_) continue;
    uint32_t child = entry.child;
    while ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[child];
      child = stack.descend(node, overlapping(node, t_in), t_in);
    }
    if (child == kBvhNoChild) continue;
    for (const auto& block : LeafBlocks<W>(scene_, child)) test_block(block);
    if (kAny && best_ != -1) return true;
  }
  return best_ != -1;
}

// Triangles that the line may pass through; sure: those that it does.
template <int W, bool kAny>
uint32_t RayTracer<W, kAny>::candidates(const TriangleBlock<W>& block, size_t first,
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
void RayTracer<W, kAny>::test_block(const TriangleBlock<W>& block) {
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
bool RayTracer<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, float& exact_t) const {
  TESSERA_COUNT(exact, 1);
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  const ExactHit exact = exact_hit(origin_, direction_, triangle);
  exact_t = exact.t;
  return exact.is_hit;
}

template <int W, bool kAny>
void RayTracer<W, kAny>::test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure) {
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
