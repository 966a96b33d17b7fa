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
// 2013. With s the largest coordinate of a corner from the origin and D the largest extent of an
// edge across the ray, the error of an edge function is at most
//   10 u s D  corners across the ray: 5 u s each (moved, sheared by a rounded quotient, rounded)
//    8 u s D  two products of at most D D, D <= 4 s
// half as much again beyond the span, and room for the bound's own roundings: 32 u s D.
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
  // Corners across the ray and edge functions of kStep triangles.
  struct Sheared {
    alignas(64) float x[3][kStep], y[3][kStep], edge[3][kStep];
  };

  // A limit of t, moved out by what a reported t may be off (plane-inl.h).
  static float widened(float t, float sign) { return t + sign * abs_of(t) * 0x1p-11f; }

  bool setup(const SingleRay& ray);
  void setup_axis(int axis, float largest, float reach);
  uint32_t overlapping(const BvhNode<W>& node, float* t_in) const;
  void test_block(const TriangleBlock<W>& block);
  uint32_t candidates(const TriangleBlock<W>& block, size_t first, Sheared& sheared) const;
  bool is_sure(const TriangleBlock<W>& block, size_t lane, const Sheared& sheared, size_t at,
               float& thin) const;
  void test_triangle(const TriangleBlock<W>& block, size_t lane, const Sheared& sheared, size_t at);

  const BvhView<W>& scene_;
  float origin_[3], direction_[3];
  float slope_[3];             // direction, scaled by a power of two where it is extreme
  float inverse_[3], pad_[3];  // of slope_
  float shear_x_ = 0, shear_y_ = 0;
  float coarse_ = 0;  // tolerance of an edge function per size of its triangle
  float scale_ = 1;   // t of slope_ = t * scale_
  float size_ = 0;    // sum of |direction|
  bool is_extreme_ = false;
  int kx_ = 0, ky_ = 1, kz_ = 2;
  float t_min_ = 0, best_t_ = 0;
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
  is_extreme_ = !(largest > 0x1p-60f && largest < 0x1p60f);
  scale_ = 1;
  while (is_extreme_ && !(largest >= 1 && largest < 2)) {
    const float factor = largest < 1 ? 2 : 0.5f;
    for (float& slope : slope_) slope *= factor;
    largest *= factor;
    scale_ /= factor;
  }
  for (int a = 0; a < 3; ++a) setup_axis(a, largest, reach);
  // |corner| <= reach, |extent| <= 2 size: no less than 32 u s D.
  coarse_ = 64 * kRoundoff * reach * (1 + 4 * kRoundoff);
  shear_x_ = slope_[kx_] / slope_[kz_];
  shear_y_ = slope_[ky_] / slope_[kz_];
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
}

template <int W, bool kAny>
uint32_t RayTracer<W, kAny>::overlapping(const BvhNode<W>& node, float* t_in) const {
  const B b;
  const V near_limit = hn::Set(b, widened(t_min_ * scale_, -1));
  const V far_limit = hn::Set(b, widened(best_t_ * scale_, 1));
  const float* in[3];
  const float* out[3];
  for (int a = 0; a < 3; ++a) {
    in[a] = inverse_[a] < 0 ? node.upper[a] : node.lower[a];
    out[a] = inverse_[a] < 0 ? node.lower[a] : node.upper[a];
  }
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
    auto keep = hn::And(hn::Le(first, widest), hn::Ge(widest, near_limit));
    keep = hn::And(keep, hn::Le(first, far_limit));
    hn::Store(first, b, t_in + i);
    bits |= bits_of(b, keep) << i;
  }
  return bits;
}

template <int W, bool kAny>
bool RayTracer<W, kAny>::run(const SingleRay& ray) {
  best_ = -1;
  if (!setup(ray)) return false;
  alignas(64) float t_in[W];
  NodeStack<W> stack(scene_);
  while (!stack.is_empty()) {
    const StackEntry entry = stack.pop();
    if (entry.distance > widened(best_t_ * scale_, 1)) continue;
    if ((entry.child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[entry.child];
      stack.push(node, overlapping(node, t_in), t_in);
      continue;
    }
    for (const auto& block : LeafBlocks<W>(scene_, entry.child)) test_block(block);
    if (kAny && best_ != -1) return true;
  }
  return best_ != -1;
}

// Triangles that the line may pass through. One tolerance for the three edges of a triangle, for
// the largest distance in the scene and a bound on its extent: few triangles pass it wrongly.
template <int W, bool kAny>
uint32_t RayTracer<W, kAny>::candidates(const TriangleBlock<W>& block, size_t first,
                                        Sheared& sheared) const {
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
  V edge[3];
  for (int c = 0; c < 3; ++c) {
    const int e = (c + 1) % 3;
    edge[c] = hn::MulSub(x[c], y[e], hn::Mul(y[c], x[e]));
  }
  const V tolerance = hn::MulAdd(size, hn::Set(b, coarse_), hn::Set(b, kUnderflow));
  const auto is_left = hn::Ge(hn::Min(hn::Min(edge[0], edge[1]), edge[2]), hn::Neg(tolerance));
  const auto is_right = hn::Le(hn::Max(hn::Max(edge[0], edge[1]), edge[2]), tolerance);
  const uint32_t bits = bits_of(b, hn::Or(is_left, is_right));
  if (bits == 0) return 0;
  for (int c = 0; c < 3; ++c) {
    hn::Store(x[c], b, sheared.x[c]);
    hn::Store(y[c], b, sheared.y[c]);
    hn::Store(edge[c], b, sheared.edge[c]);
  }
  return bits;
}

template <int W, bool kAny>
void RayTracer<W, kAny>::test_block(const TriangleBlock<W>& block) {
  Sheared sheared;
  for (size_t first = 0; first < W; first += kStep) {
    for (uint32_t bits = candidates(block, first, sheared); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      test_triangle(block, first + lane, sheared, lane);
    }
  }
}

// Whether the edge functions alone say that the line passes through the triangle. thin: the least
// |N.D| / |D main| of a triangle that is thick enough for that.
template <int W, bool kAny>
bool RayTracer<W, kAny>::is_sure(const TriangleBlock<W>& block, size_t lane, const Sheared& sheared,
                                 size_t at, float& thin) const {
  float size = 0;
  for (size_t k = 0; k < 9; ++k)
    size = max_of(size, abs_of(block.vertex[k][lane] - origin_[k % 3]));
  const float per_length = 32 * kRoundoff * size;
  bool is_left = true, is_right = true;
  float longest = 0;
  for (int c = 0; c < 3; ++c) {
    const int e = (c + 1) % 3;
    const float extent = max_of(abs_of(sheared.x[e][at] - sheared.x[c][at]),
                                abs_of(sheared.y[e][at] - sheared.y[c][at]));
    const float tolerance = extent * per_length + kUnderflow;
    is_left = is_left && sheared.edge[c][at] > tolerance;
    is_right = is_right && sheared.edge[c][at] < -tolerance;
    longest = max_of(longest, tolerance);
  }
  thin = 8 * longest;
  return is_left || is_right;
}

template <int W, bool kAny>
void RayTracer<W, kAny>::test_triangle(const TriangleBlock<W>& block, size_t lane,
                                       const Sheared& sheared, size_t at) {
  const Plane plane = plane_of(block, lane, origin_);
  float t = 0, speed = 0, thin = 0;
  bool counts = plane_t(plane, direction_[0], direction_[1], direction_[2], size_, speed, t);
  counts = counts && !is_extreme_;
  const auto number = static_cast<int32_t>(block.primitive[lane]);
  const bool is_lower = best_ == -1 || number < best_;
  const auto in_range = [&] { return t >= t_min_ && (t < best_t_ || (t == best_t_ && is_lower)); };
  if (counts && !in_range()) return;
  if (!counts || !is_sure(block, lane, sheared, at, thin) ||
      !(abs_of(speed) > thin * abs_of(direction_[kz_]))) {
    float triangle[9];
    for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
    const ExactHit exact = exact_hit(origin_, direction_, triangle);
    if (!exact.is_hit) return;
    if (!counts) t = exact.t;
    if (!in_range()) return;
  }
  best_t_ = kAny ? -__builtin_inff() : t;
  best_ = number;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
