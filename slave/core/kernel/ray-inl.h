// Traversal of a wide hierarchy by one ray: all children of a node at once, closest and any hit. For
// rays that have no company: bounces, and packets that are none.
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
// Threads. One traversal owns one.
#include "slave/core/kernel/packet_layout.h"

#if defined(TESSERA_CORE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_RAY_INL_H_
#undef TESSERA_CORE_RAY_INL_H_
#else
#define TESSERA_CORE_RAY_INL_H_
#endif

#include "slave/core/kernel/node_stack-inl.h"
#include "slave/core/kernel/ray_state-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
class BvhRayTracer : public RayState<W, kAny> {
  using State = RayState<W, kAny>;
  using State::kStep;
  using typename State::B;
  using typename State::V;

 public:
  explicit BvhRayTracer(const BvhView<W>& scene) : scene_(scene) {}

  // Returns: whether there is a hit.
  bool run(const SingleRay& ray);

 private:
  HWY_INLINE uint32_t overlapping(const BvhNode<W>& node, float* t_in) const;

  const BvhView<W>& scene_;
};

template <int W, bool kAny>
uint32_t BvhRayTracer<W, kAny>::overlapping(const BvhNode<W>& node, float* t_in) const {
  const B b;
  const float* in[3];
  const float* out[3];
  for (int a = 0; a < 3; ++a) {
    in[a] = this->is_down_[a] ? node.upper[a] : node.lower[a];
    out[a] = this->is_down_[a] ? node.lower[a] : node.upper[a];
  }
  TESSERA_COUNT(nodes, 1);
  uint32_t bits = 0;
  for (size_t i = 0; i < W; i += kStep) {
    const auto enter = [&](int a) {
      const V plane = hn::Sub(hn::Load(b, in[a] + i), hn::Set(b, this->origin_[a]));
      return hn::MulSub(plane, hn::Set(b, this->inverse_[a]), hn::Set(b, this->pad_[a]));
    };
    const auto leave = [&](int a) {
      const V plane = hn::Sub(hn::Load(b, out[a] + i), hn::Set(b, this->origin_[a]));
      return hn::MulAdd(plane, hn::Set(b, this->inverse_[a]), hn::Set(b, this->pad_[a]));
    };
    const V first = hn::Max(hn::Max(enter(0), enter(1)), enter(2));
    const V last = hn::Min(hn::Min(leave(0), leave(1)), leave(2));
    const V widest = hn::MulAdd(hn::Abs(last), hn::Set(b, 16 * kRoundoff), last);
    auto keep = hn::And(hn::Le(first, widest), hn::Ge(widest, hn::Set(b, this->near_limit_)));
    keep = hn::And(keep, hn::Le(first, hn::Set(b, this->far_limit_)));
    hn::Store(first, b, t_in + i);
    bits |= bits_of(b, keep) << i;
  }
  TESSERA_COUNT(children, __builtin_popcount(bits));
  return bits;
}

template <int W, bool kAny>
bool BvhRayTracer<W, kAny>::run(const SingleRay& ray) {
  if (!this->setup(ray, scene_.lower, scene_.upper)) return false;
  TESSERA_COUNT(singles, 1);
  alignas(64) float t_in[W];
  NodeStack<W> stack(scene_);
  while (!stack.is_empty()) {
    const StackEntry entry = stack.pop();
    if (entry.distance > this->far_limit_) continue;
    uint32_t child = entry.child;
    while ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[child];
      child = stack.descend(node, overlapping(node, t_in), t_in);
    }
    if (child == kBvhNoChild) continue;
    for (const auto& block : LeafBlocks<W>(scene_, child)) this->test_block(block);
    if (kAny && this->best_ != -1) return true;
  }
  return this->best_ != -1;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
