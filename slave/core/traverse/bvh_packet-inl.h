// Traversal of a wide hierarchy by 64 rays as one frustum; closest and any hit. Rays are a FanRays
// or a BundleRays, Block the test of their triangles.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_BVH_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_PACKET_INL_H_
#undef TESSERA_CORE_BVH_PACKET_INL_H_
#else
#define TESSERA_CORE_BVH_PACKET_INL_H_
#endif

#include "slave/core/ray/frustum-inl.h"
#include "slave/core/traverse/node_stack-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, class Rays, class Block>
class PacketTracer {
 public:
  // Work per ray after which a packet does not pay: what one ray by itself takes, which is less where
  // any hit will do.
  static constexpr int kWorkMax = Block::kIsAny ? 12 : 24;

  explicit PacketTracer(const BvhView<W>& scene) : scene_(scene), block_(rays_) {}

  template <class Packet>
  Together run(const Packet& packet) {
    if (!rays_.setup(packet)) return Together::kNoFrustum;
    rays_.work_left = kWorkMax * rays_.count;
    TESSERA_COUNT(packets, 1);
    int steps = 0;
    alignas(64) float z_near[W];
    NodeStack<W> stack(scene_);
    for (uint32_t child = begin(packet, stack); child != kBvhNoChild;
         child = stack.next(rays_.z_far)) {
      while ((child & kBvhLeaf) == 0) {
        if (++steps > Rays::kStepsMax) return Together::kDoesNotPay;
        const BvhNode<W>& node = scene_.nodes[child];
        child = stack.descend(node, FrustumTests<W>::boxes(rays_, node, z_near), z_near);
      }
      if (child == kBvhNoChild) continue;
      bool has_hit = false;
      for (const auto& block : LeafBlocks<W>(scene_, child)) has_hit |= block_.test(block);
      if (has_hit) rays_.shorten();
      if (rays_.work_left < 0) return Together::kDoesNotPay;
    }
    return Together::kDone;
  }

  const Rays& rays() const { return rays_; }

 private:
  // The first child to go to; the others are on the stack.
  template <class Packet>
  HWY_INLINE uint32_t begin(const Packet& packet, NodeStack<W>& stack) const {
    const FanEntry* const entry = entry_of(packet);
    if (entry == nullptr) return stack.next(rays_.z_far);
    alignas(64) float z_near[kEntryWidth];
    const uint32_t met = FrustumTests<kEntryWidth>::boxes(rays_, entry->top, z_near);
    return stack.enter(entry->top, met, z_near);
  }

  const BvhView<W>& scene_;
  Rays rays_;
  Block block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
