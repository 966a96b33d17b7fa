// SPDX-License-Identifier: Apache-2.0
// Traversal of a kd-tree: by 64 rays as one frustum, and by one ray; closest and any hit.
//
// A frustum is in a voxel between two depths along its main axis. At a split plane across that axis
// the order of the children is the order of depth; at another plane the frustum reaches the far
// child no earlier than its outermost plane does and leaves the near one no later than its
// innermost. Depths are moved out by the roundings of the quotient, so a box that touches a split
// plane may stand on one side of it alone: what comes to the plane looks on both sides. Children
// may be visited in any order, since hits are not cut off at voxels; a primitive that stands in
// several leaves gives the same answer again.
//
// After Reshetov, Soupikov, Hurley, 2005 (frustum), and Hapala and Havran, "Review: kd-tree
// traversal algorithms for ray tracing", 2011 (one ray).
//
// Threads. One traversal owns one.
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_KD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_KD_INL_H_
#undef TESSERA_CORE_KD_INL_H_
#else
#define TESSERA_CORE_KD_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/ray/packet_rays-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// A subtree, and from where to where along the frustum or ray it is to be looked at.
struct KdEntry {
  uint32_t node;
  float from, to;
};

// The stack cannot overflow: a step down pushes one entry at most.
struct KdStack {
  KdEntry entries[kKdDepthMax + 1];
  int size = 0;

  bool is_empty() const { return size == 0; }
  void push(const KdEntry& entry) { entries[size++] = entry; }
  KdEntry pop() { return entries[--size]; }
};

HWY_INLINE bool is_kd_leaf(const KdNode& node) { return (node.tag_and_index & 3u) == kKdLeafTag; }

template <class View>
HWY_INLINE void prefetch_kd(const View& scene, uint32_t node) {
  __builtin_prefetch(scene.nodes + node);
}

template <class View, class Rays, class Leaf>
class KdPacketTracer {
 public:
  // Limit of work, as in PacketTracer; one ray by itself takes three times as long here.
  static constexpr int kWorkMax = 100;

  explicit KdPacketTracer(const View& scene) : scene_(scene), leaf_(rays_) {}

  template <class Packet>
  Together run(const Packet& packet);
  // Requires: run() returned kDone.
  void write_to(const HitArrays& hits) {
    leaf_.finish();
    rays_.write_to(hits);
  }
  uint64_t blocked() const { return rays_.blocked(); }

 private:
  struct Voxel {
    float lower[3], upper[3];
  };
  static Voxel voxel_of(const SceneBox& box) {
    return {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
  }
  static Voxel voxel_of(const BvhNode<kEntryWidth>& top) {
    return {{top.lower[0][0], top.lower[1][0], top.lower[2][0]},
            {top.upper[0][0], top.upper[1][0], top.upper[2][0]}};
  }
  // The part of an axis that the frustum covers between two depths.
  struct Range {
    float low, high;
  };
  HWY_INLINE Range covered(int axis, float from, float to) const;
  HWY_INLINE bool enter(uint32_t node, const Voxel& voxel, KdEntry& entry) const;
  HWY_INLINE uint32_t descend(const KdNode& node, KdEntry& entry);
  HWY_INLINE uint32_t descend_across(int axis, float plane, uint32_t lower, KdEntry& entry);
  HWY_INLINE void visit(const KdNode& leaf);
  HWY_INLINE void shorten();
  HWY_INLINE void invert_slopes();

  const View& scene_;
  Rays rays_;
  Leaf leaf_;
  KdStack stack_;
  float inverse_[2][2];  // of the slopes, by axis (u, v) and side; infinite for slopes of zero
};

template <class View, class Rays, class Leaf>
typename KdPacketTracer<View, Rays, Leaf>::Range KdPacketTracer<View, Rays, Leaf>::covered(
    int axis, float from, float to) const {
  const float* const slope = axis == rays_.kx ? rays_.slope_u : rays_.slope_v;
  const float* const offset = axis == rays_.kx ? rays_.offset_u : rays_.offset_v;
  return {slope[0] * (slope[0] < 0 ? to : from) + offset[0],
          slope[1] * (slope[1] < 0 ? from : to) + offset[1]};
}

// Cuts the frustum to a voxel. Returns: whether anything is left.
template <class View, class Rays, class Leaf>
bool KdPacketTracer<View, Rays, Leaf>::enter(uint32_t node, const Voxel& voxel,
                                             KdEntry& entry) const {
  const float a = (voxel.lower[rays_.kz] - rays_.origin[rays_.kz]) * rays_.side;
  const float b = (voxel.upper[rays_.kz] - rays_.origin[rays_.kz]) * rays_.side;
  entry = {node, max_of(min_of(a, b), 0.0f), min_of(max_of(a, b), rays_.z_far)};
  if (!(entry.from <= entry.to)) return false;
  for (const int axis : {rays_.kx, rays_.ky}) {
    const Range range = covered(axis, entry.from, entry.to);
    if (range.high < voxel.lower[axis] - rays_.origin[axis]) return false;
    if (range.low > voxel.upper[axis] - rays_.origin[axis]) return false;
  }
  return true;
}

// Returns: the child to go on with; another to visit goes onto the stack.
template <class View, class Rays, class Leaf>
uint32_t KdPacketTracer<View, Rays, Leaf>::descend(const KdNode& node, KdEntry& entry) {
  const int axis = static_cast<int>(node.tag_and_index & 3u);
  const uint32_t lower = node.tag_and_index >> 2;
  const float plane = node.split - rays_.origin[axis];
  if (axis != rays_.kz) return descend_across(axis, plane, lower, entry);
  const float depth = plane * rays_.side;
  const uint32_t near = rays_.side > 0 ? lower : lower + 1,
                 far = rays_.side > 0 ? lower + 1 : lower;
  if (depth > entry.to) return near;
  if (depth < entry.from) return far;
  stack_.push({far, depth, entry.to});
  prefetch_kd(scene_, far);
  entry.to = depth;
  return near;
}

template <class View, class Rays, class Leaf>
uint32_t KdPacketTracer<View, Rays, Leaf>::descend_across(int axis, float plane, uint32_t lower,
                                                          KdEntry& entry) {
  const Range range = covered(axis, entry.from, entry.to);
  if (range.high < plane) return lower;
  if (range.low > plane) return lower + 1;
  const int k = axis == rays_.kx ? 0 : 1;
  const float* const slope = k == 0 ? rays_.slope_u : rays_.slope_v;
  const float* const offset = k == 0 ? rays_.offset_u : rays_.offset_v;
  // Whether the frustum begins mostly below the plane, or above it.
  const float middle =
      (offset[0] + offset[1]) + (slope[0] + slope[1]) * entry.from;  // twice the middle
  const bool is_below = middle < 2 * plane;
  // Which of the two planes of the frustum goes through the split plane first, and which last.
  const int first = is_below ? 1 : 0, last = 1 - first;
  const float sign = is_below ? 1.0f : -1.0f;
  const float slack = abs_of(plane) * (4 * kRoundoff);
  KdEntry far{is_below ? lower + 1 : lower, entry.from, entry.to};
  if (slope[first] * sign > 0) {
    const float depth = ((plane - offset[first]) * sign - slack) * inverse_[k][first] * sign;
    far.from = max_of(far.from, depth - abs_of(depth) * (8 * kRoundoff));
  }
  if (slope[last] * sign > 0) {
    const float depth = ((plane - offset[last]) * sign + slack) * inverse_[k][last] * sign;
    entry.to = min_of(entry.to, depth + abs_of(depth) * (8 * kRoundoff));
  }
  const uint32_t near = is_below ? lower : lower + 1;
  if (far.from > far.to) return near;
  if (entry.from > entry.to) {
    entry = far;
    return far.node;
  }
  stack_.push(far);
  prefetch_kd(scene_, far.node);
  return near;
}

// Tests the blocks of a leaf whose boxes the frustum meets.
template <class View, class Rays, class Leaf>
void KdPacketTracer<View, Rays, Leaf>::visit(const KdNode& leaf) {
  constexpr int W = View::kWidth;
  const BvhNode<W>* blocks = scene_.leaves + (leaf.tag_and_index >> 2);
  for (const BvhNode<W>* const end = blocks + leaf.count; blocks != end; ++blocks) {
    alignas(64) float z_near[W];
    uint32_t met = FrustumTests<W>::boxes(rays_, *blocks, z_near);
    for (; met != 0; met &= met - 1) {
      const int i = __builtin_ctz(met);
      if (z_near[i] > rays_.z_far) continue;
      if (leaf_.test(scene_.shapes, blocks->child[i], 1)) shorten();
    }
  }
}

template <class View, class Rays, class Leaf>
void KdPacketTracer<View, Rays, Leaf>::shorten() {
  rays_.shorten();
  if constexpr (Leaf::kIsAny && kHasDiagonals<Rays>) {
    rays_.narrow();
    invert_slopes();
  }
}

template <class View, class Rays, class Leaf>
void KdPacketTracer<View, Rays, Leaf>::invert_slopes() {
  for (int i = 0; i < 2; ++i) {
    inverse_[0][i] = 1 / rays_.slope_u[i];
    inverse_[1][i] = 1 / rays_.slope_v[i];
  }
}

template <class View, class Rays, class Leaf>
template <class Packet>
Together KdPacketTracer<View, Rays, Leaf>::run(const Packet& packet) {
  if (!rays_.setup(packet)) return Together::kNoFrustum;
  rays_.set_reach(scene_.box);
  leaf_.prepare();
  rays_.work_left = kWorkMax * rays_.count;
  TESSERA_COUNT(packets, 1);
  invert_slopes();
  KdEntry begin;
  if (scene_.nodes == nullptr) return Together::kDone;
  if (const FanEntry* const found = entry_of(packet)) {
    const uint32_t node = found->top.child[0];
    if (node == kBvhNoChild || !enter(node, voxel_of(found->top), begin)) return Together::kDone;
  } else if (!enter(0, voxel_of(scene_.box), begin)) {
    return Together::kDone;
  }
  stack_.push(begin);
  int steps = 0;
  while (!stack_.is_empty()) {
    KdEntry entry = stack_.pop();
    if (entry.from > rays_.z_far) continue;
    entry.to = min_of(entry.to, rays_.z_far);
    uint32_t node = entry.node;
    while (!is_kd_leaf(scene_.nodes[node])) {
      if (++steps > Rays::kKdStepsMax) return Together::kDoesNotPay;
      TESSERA_COUNT(nodes, 1);
      node = descend(scene_.nodes[node], entry);
    }
    visit(scene_.nodes[node]);
    if (rays_.work_left < 0) return Together::kDoesNotPay;
  }
  if constexpr (requires { leaf_.settle_waiting(); }) leaf_.settle_waiting();
  return Together::kDone;
}

// From where to where a ray is in the scene's box; from > to where it misses it.
HWY_INLINE KdEntry kd_root(const OneRay& ray, const SceneBox& box) {
  KdEntry root{0, ray.near_limit, ray.far_limit};
  for (int a = 0; a < 3; ++a) {
    const float p = (box.lower[a] - ray.origin[a]) * ray.inverse[a];
    const float q = (box.upper[a] - ray.origin[a]) * ray.inverse[a];
    const float first = ray.is_down(a) ? q : p, last = ray.is_down(a) ? p : q;
    root.from = max_of(root.from, first - abs_of(first) * (8 * kRoundoff) - ray.pad[a]);
    root.to = min_of(root.to, last + abs_of(last) * (8 * kRoundoff) + ray.pad[a]);
  }
  return root;
}

template <class View, class Leaf>
class KdRayTracer {
 public:
  explicit KdRayTracer(const View& scene) : scene_(scene), leaf_(ray_) {}

  // Returns: whether there is a hit. blocker: for any hit, a block to test first, or kNoBlock;
  // becomes the block of the hit.
  bool run(const SingleRay& ray, uint32_t& blocker);
  bool run(const SingleRay& ray) {
    uint32_t none = kNoBlock;
    return run(ray, none);
  }

  const OneRay& ray() const { return ray_; }

 private:
  HWY_INLINE uint32_t descend(const KdNode& node, KdEntry& entry);
  HWY_INLINE uint32_t blocker_in(const KdNode& leaf);

  const View& scene_;
  OneRay ray_;
  RaySlabs<View::kWidth> slabs_;
  Leaf leaf_;
  KdStack stack_;
};

// Roundings of t at the plane: difference, reciprocal, product, 1 u each.
template <class View, class Leaf>
uint32_t KdRayTracer<View, Leaf>::descend(const KdNode& node, KdEntry& entry) {
  const int axis = static_cast<int>(node.tag_and_index & 3u);
  const uint32_t lower = node.tag_and_index >> 2;
  const float t = (node.split - ray_.origin[axis]) * ray_.inverse[axis];
  const float slack = abs_of(t) * (8 * kRoundoff) + ray_.pad[axis];
  const uint32_t near = ray_.is_down(axis) ? lower + 1 : lower;
  const uint32_t far = ray_.is_down(axis) ? lower : lower + 1;
  if (t - slack > entry.to) return near;
  if (t + slack < entry.from) return far;
  stack_.push({far, max_of(entry.from, t - slack), entry.to});
  prefetch_kd(scene_, far);
  entry.to = min_of(entry.to, t + slack);
  return near;
}

// Tests the blocks of a leaf whose boxes the ray meets. Returns: where any hit will do, the block
// with a hit; kNoBlock where there is none, and for closest hits.
template <class View, class Leaf>
uint32_t KdRayTracer<View, Leaf>::blocker_in(const KdNode& leaf) {
  constexpr int W = View::kWidth;
  const BvhNode<W>* blocks = scene_.leaves + (leaf.tag_and_index >> 2);
  for (const BvhNode<W>* const end = blocks + leaf.count; blocks != end; ++blocks) {
    alignas(64) float t_in[W];
    uint32_t met = slabs_.overlapping(ray_, *blocks, t_in);
    for (; met != 0; met &= met - 1) {
      const int i = __builtin_ctz(met);
      if (t_in[i] > ray_.far_limit) continue;
      const uint32_t block = leaf_.test(scene_.shapes, blocks->child[i], 1);
      if (Leaf::kIsAny && block != kNoBlock) return block;
    }
  }
  return kNoBlock;
}

template <class View, class Leaf>
bool KdRayTracer<View, Leaf>::run(const SingleRay& ray, uint32_t& blocker) {
  if (scene_.nodes == nullptr || !ray_.setup(ray, scene_.box)) return false;
  leaf_.prepare();
  TESSERA_COUNT(singles, 1);
  if (Leaf::kIsAny && blocker != kNoBlock && leaf_.test(scene_.shapes, blocker, 1) != kNoBlock)
    return true;
  slabs_.setup(ray_, scene_.box);
  const KdEntry root = kd_root(ray_, scene_.box);
  if (!(root.from <= root.to)) return false;
  stack_.push(root);
  while (!stack_.is_empty()) {
    KdEntry entry = stack_.pop();
    if (entry.from > ray_.far_limit) continue;
    uint32_t node = entry.node;
    while (!is_kd_leaf(scene_.nodes[node])) {
      TESSERA_COUNT(nodes, 1);
      node = descend(scene_.nodes[node], entry);
    }
    const uint32_t block = blocker_in(scene_.nodes[node]);
    if (Leaf::kIsAny && block != kNoBlock) {
      blocker = block;
      return true;
    }
  }
  return ray_.has_hit();
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
