// Traversal of a wide hierarchy by 64 rays that leave one point, as one frustum; closest and any
// hit.
//
// After Reshetov, Soupikov, Hurley, "Multi-level ray tracing algorithm", 2005. Boxes are compared
// with the frustum in coordinates relative to the origin: rounding is monotonic, so their order is
// never wrong, and the bounds of the frustum are moved out by what their products with the depth
// may be off.
#include "slave/core/kernel/packet_layout.h"

#if defined(TESSERA_CORE_FAN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_INL_H_
#undef TESSERA_CORE_FAN_INL_H_
#else
#define TESSERA_CORE_FAN_INL_H_
#endif

#include "slave/core/kernel/fan_block-inl.h"
#include "slave/core/kernel/node_stack-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
class FanTracer {
  using B = hn::CappedTag<float, W>;  // children
  using VB = hn::Vec<B>;
  static constexpr size_t kStep = hn::MaxLanes(B());

 public:
  explicit FanTracer(const BvhView<W>& scene) : scene_(scene), block_(fan_) {}

  // Returns: false, with nothing done, where the rays are no frustum.
  bool run(const FanPacket& rays);
  const FanRays& fan() const { return fan_; }

 private:
  uint32_t overlapping(const BvhNode<W>& node, float* z_near) const;

  const BvhView<W>& scene_;
  FanRays fan_;
  FanBlock<W, kAny> block_;
};

// Children whose box meets the frustum, with the depth at which each begins.
template <int W, bool kAny>
uint32_t FanTracer<W, kAny>::overlapping(const BvhNode<W>& node, float* z_near) const {
  const B b;
  const float* const z_in = fan_.side > 0 ? node.lower[fan_.kz] : node.upper[fan_.kz];
  const float* const z_out = fan_.side > 0 ? node.upper[fan_.kz] : node.lower[fan_.kz];
  const VB side = hn::Set(b, fan_.side), zero = hn::Zero(b);
  const VB ox = hn::Set(b, fan_.origin[fan_.kx]), oy = hn::Set(b, fan_.origin[fan_.ky]);
  const VB oz = hn::Set(b, fan_.origin[fan_.kz]);
  TESSERA_COUNT(nodes, 1);
  uint32_t bits = 0;
  for (size_t i = 0; i < W; i += kStep) {
    const VB in = hn::Mul(hn::Sub(hn::Load(b, z_in + i), oz), side);
    const VB out = hn::Mul(hn::Sub(hn::Load(b, z_out + i), oz), side);
    const VB front = hn::Max(in, zero);
    const auto reach = [&](float bound, bool is_far) {
      return hn::Mul(hn::Set(b, bound), is_far ? out : front);
    };
    auto keep = hn::Ge(reach(fan_.bound_u[1], fan_.bound_u[1] >= 0),
                       hn::Sub(hn::Load(b, node.lower[fan_.kx] + i), ox));
    keep = hn::And(keep, hn::Le(reach(fan_.bound_u[0], fan_.bound_u[0] < 0),
                                hn::Sub(hn::Load(b, node.upper[fan_.kx] + i), ox)));
    keep = hn::And(keep, hn::Ge(reach(fan_.bound_v[1], fan_.bound_v[1] >= 0),
                                hn::Sub(hn::Load(b, node.lower[fan_.ky] + i), oy)));
    keep = hn::And(keep, hn::Le(reach(fan_.bound_v[0], fan_.bound_v[0] < 0),
                                hn::Sub(hn::Load(b, node.upper[fan_.ky] + i), oy)));
    keep = hn::And(keep, hn::And(hn::Ge(out, zero), hn::Le(in, hn::Set(b, fan_.z_far))));
    hn::Store(in, b, z_near + i);
    bits |= bits_of(b, keep) << i;
  }
  TESSERA_COUNT(children, __builtin_popcount(bits));
  return bits;
}

template <int W, bool kAny>
bool FanTracer<W, kAny>::run(const FanPacket& rays) {
  if (!fan_.setup(rays)) return false;
  TESSERA_COUNT(packets, 1);
  alignas(64) float z_near[W];
  NodeStack<W> stack(scene_);
  while (!stack.is_empty()) {
    const StackEntry entry = stack.pop();
    if (entry.distance > fan_.z_far) continue;
    if ((entry.child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[entry.child];
      stack.push(node, overlapping(node, z_near), z_near);
      continue;
    }
    bool has_hit = false;
    for (const auto& block : LeafBlocks<W>(scene_, entry.child)) has_hit |= block_.test(block);
    if (has_hit) fan_.shorten();
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
