// SPDX-License-Identifier: Apache-2.0
// Traversal of a wide hierarchy by 64 rays as one frustum; closest and any hit. Rays are a FanRays
// or a BundleRays, Leaf is the test of what is in leaves (primitive/leaf-inl.h).
//
// Threads. One traversal owns one.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_BVH_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_PACKET_INL_H_
#undef TESSERA_CORE_BVH_PACKET_INL_H_
#else
#define TESSERA_CORE_BVH_PACKET_INL_H_
#endif

#include "slave/core/ray/frustum-inl.h"
#include "slave/core/ray/packet_rays-inl.h"
#include "slave/core/traverse/node_stack-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// The subtrees of an entry list that a frustum meets. They are in order already and stay where they
// are, so that what is behind the rays' hits costs nothing.
template <class View>
class EnteredTrees {
 public:
  explicit EnteredTrees(const View& scene) : scene_(scene) {}

  HWY_INLINE void find(const Frustum& frustum, const FanEntry& entry) {
    top_ = &entry.top;
    left_ = FrustumTests<kEntryWidth>::boxes(frustum, entry.top, z_near_);
    fetch_nearest();
  }
  // The nearest that is left, where it begins at `far` or before it; else kBvhNoChild.
  HWY_INLINE uint32_t next(float far) {
    if (left_ == 0) return kBvhNoChild;
    const int nearest = __builtin_ctz(left_);
    left_ &= left_ - 1;
    fetch_nearest();
    if (z_near_[nearest] <= far) return top_->child[nearest];
    left_ = 0;
    return kBvhNoChild;
  }

 private:
  HWY_INLINE void fetch_nearest() const {
    if (left_ != 0) fetch_child<kAllLines<View>>(scene_, top_->child[__builtin_ctz(left_)]);
  }

  const View& scene_;
  const BvhNode<kEntryWidth>* top_ = nullptr;
  uint32_t left_ = 0;
  alignas(64) float z_near_[kEntryWidth] = {};
};

template <class View, class Rays, class Leaf>
class PacketTracer {
  static constexpr int W = View::kWidth;

 public:
  // Work per ray after which a packet does not pay, in tests of a row. A ray by itself takes the
  // cycles of some 13 of them (10 to 20), boxes and culling included. Who gives a packet up at that
  // loses at most as much again; what it has done, and its neighbours that are not tried then, are
  // lost, too, so the best limits lie above: they are those of the least mean time in
  // ../decisions/packets-pay.md, from which tests/bench/self_test.py finds them again.
  static constexpr int kWorkMax = Leaf::kIsAny ? 16 : 24;

  explicit PacketTracer(const View& scene) : scene_(scene), leaf_(rays_) {}

  template <class Packet>
  Together run(const Packet& packet) {
    if (!rays_.setup(packet)) return Together::kNoFrustum;
    rays_.set_reach(scene_.box);
    leaf_.prepare();
    rays_.work_left = kWorkMax * rays_.count;
    TESSERA_COUNT(packets, 1);
    int steps = 0;
    alignas(64) float z_near[W];
    NodeStack<View, kAllLines<View>> stack(scene_);
    EnteredTrees<View> entered(scene_);
    if (const FanEntry* const entry = entry_of(packet)) {
      entered.find(rays_, *entry);
      stack.clear();
    }
    const auto next = [&]() HWY_ATTR {
      const uint32_t child = stack.next(rays_.z_far);
      return HWY_UNLIKELY(child == kBvhNoChild) ? entered.next(rays_.z_far) : child;
    };
    for (uint32_t child = next(); child != kBvhNoChild; child = next()) {
      while ((child & kBvhLeaf) == 0) {
        if (++steps > Rays::kStepsMax) return Together::kDoesNotPay;
        const BvhNode<W>& node = scene_.nodes[child];
        child = stack.descend(node, FrustumTests<W>::boxes(rays_, node, z_near), z_near);
      }
      if (child == kBvhNoChild) continue;
      if (leaf_.test(scene_.shapes, leaf_first(child), leaf_count(child))) {
        rays_.shorten();
        // Rays that are blocked look for nothing any more.
        if constexpr (Leaf::kIsAny && kHasDiagonals<Rays>) rays_.narrow();
      }
      if (rays_.work_left < 0) return Together::kDoesNotPay;
    }
    if constexpr (requires { leaf_.settle_waiting(); }) leaf_.settle_waiting();
    return Together::kDone;
  }

  // Requires: run() returned kDone.
  void write_to(const HitArrays& hits) {
    leaf_.finish();
    rays_.write_to(hits);
  }
  uint64_t blocked() const { return rays_.blocked(); }
  const Rays& rays() const { return rays_; }
  // Whether the packet took less than a test of a row for each ray: culling is most of what it cost
  // then, and two packets may share that. Requires: run() was called.
  bool is_light() const { return kWorkMax * rays_.count - rays_.work_left < rays_.count; }

 private:
  const View& scene_;
  Rays rays_;
  Leaf leaf_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
