// SPDX-License-Identifier: Apache-2.0
// Where the fans of a tile begin: below the steps from the root that all of them would take alike.
//
// In a kd-tree it is the deepest subtree that holds everything the tile's window meets, after
// Reshetov, Soupikov, Hurley, "Multi-level ray tracing algorithm", 2005. In the hierarchy it is a
// list of up to 16 subtrees, made by opening the nearest again and again: a fan then starts with
// one step over all of them, and what lies far behind, and is hidden mostly, stays closed.
//
// Threads. Pure functions.
#include <stddef.h>

#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_ENTRY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_ENTRY_INL_H_
#undef TESSERA_CORE_ENTRY_INL_H_
#else
#define TESSERA_CORE_ENTRY_INL_H_
#endif

#include "slave/core/ray/frustum-inl.h"
#include "slave/core/traverse/kd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE Frustum frustum_of(const FanWindow& window) {
  Frustum f;
  f.set_axis(window.axis, window.side < 0);
  for (int a = 0; a < 3; ++a) f.origin[a] = window.origin[a];
  // Slopes are moved out further than those of a fan (FanRays::bound()), which are a rounding from
  // these.
  const auto outward = [](float slope, float sign) {
    return slope + sign * abs_of(slope) * (12 * kRoundoff);
  };
  f.slope_u[0] = outward(window.low[0], -1);
  f.slope_u[1] = outward(window.high[0], 1);
  f.slope_v[0] = outward(window.low[1], -1);
  f.slope_v[1] = outward(window.high[1], 1);
  f.z_far = __builtin_inff();
  return f;
}

// Subtrees in the order of where their boxes begin along the main axis, which is the same for all
// fans of a window, so that none of them has to sort. They stay where they are in nodes of W
// children until the list is written.
template <int W>
class EntryList {
 public:
  explicit EntryList(const FanWindow& window) : axis_(window.axis), side_(window.side) {}

  int count() const { return count_; }
  uint32_t child(int at) const { return child_[at]; }

  // Requires: count() < kEntryWidth; the node outlives the list.
  HWY_INLINE void insert(const BvhNode<W>& node, int child) {
    static_assert(offsetof(BvhNode<W>, upper) == 3 * W * sizeof(float));
    const float begin = (side_ > 0 ? node.lower : node.upper)[axis_][child] * side_;
    int at = count_++;
    for (; at > 0 && begin < begin_[at - 1]; --at) move(at - 1, at);
    begin_[at] = begin;
    child_[at] = node.child[child];
    corner_[at] = node.lower[0] + child;
  }

  HWY_INLINE void erase(int at) {
    --count_;
    for (; at < count_; ++at) move(at + 1, at);
  }

  void write_to(FanEntry& entry) const {
    entry.axis = axis_;
    entry.side = side_;
    BvhNode<kEntryWidth>& top = entry.top;
    for (int at = 0; at < count_; ++at) {
      for (size_t a = 0; a < 3; ++a) {
        top.lower[a][at] = corner_[at][a * W];
        top.upper[a][at] = corner_[at][(a + 3) * W];
      }
      top.child[at] = child_[at];
    }
    for (int at = count_; at < kEntryWidth; ++at) {
      for (size_t a = 0; a < 3; ++a) {
        top.lower[a][at] = __builtin_inff();
        top.upper[a][at] = -__builtin_inff();
      }
      top.child[at] = kBvhNoChild;
    }
  }

 private:
  // What was stored a moment ago is loaded again by the same widths, which processors can forward.
  HWY_INLINE void move(int from, int to) {
    begin_[to] = begin_[from];
    child_[to] = child_[from];
    corner_[to] = corner_[from];
  }

  const int axis_;
  const float side_;
  int count_ = 0;
  float begin_[kEntryWidth];  // of the near face
  uint32_t child_[kEntryWidth];
  const float* corner_[kEntryWidth];  // places in node.lower[0]; the other bounds follow, W apart
};

template <int W, class Shapes>
void find_entry(const BvhView<W, Shapes>& scene, const FanWindow& window, FanEntry& entry) {
  EntryList<W> list(window);
  if (scene.nodes == nullptr) return list.write_to(entry);
  const Frustum f = frustum_of(window);
  alignas(64) float z_near[W];
  const auto insert_met = [&](const BvhNode<W>& node, uint32_t met) {
    for (; met != 0; met &= met - 1) list.insert(node, __builtin_ctz(met));
  };
  insert_met(scene.nodes[0], FrustumTests<W>::boxes(f, scene.nodes[0], z_near));
  // Subtrees before `at` are leaves, or there is no room for what is in them.
  for (int at = 0; at < list.count();) {
    const uint32_t child = list.child(at);
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene.nodes[child];
      const uint32_t met = FrustumTests<W>::boxes(f, node, z_near);
      if (list.count() - 1 + __builtin_popcount(met) <= kEntryWidth) {
        list.erase(at);
        insert_met(node, met);  // none begins before the box that it is in
        continue;
      }
    }
    ++at;
  }
  list.write_to(entry);
}

template <int W, class Shapes>
void find_entry(const KdView<W, Shapes>& scene, const FanWindow& window, FanEntry& entry) {
  constexpr int kLanes = 4;  // two of them used
  EntryList<kLanes> list(window);
  list.write_to(entry);
  if (scene.nodes == nullptr) return;
  const Frustum f = frustum_of(window);
  BvhNode<kLanes> voxels;
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < kLanes; ++i) {
      voxels.lower[a][i] = scene.box.lower[a];
      voxels.upper[a][i] = scene.box.upper[a];
    }
  }
  voxels.child[0] = 0;
  for (int only = 0;;) {  // the voxel that everything met is in
    const KdNode& node = scene.nodes[voxels.child[only]];
    if (is_kd_leaf(node)) {
      list.insert(voxels, only);
      return list.write_to(entry);
    }
    const BvhNode<kLanes> whole = voxels;
    const uint32_t axis = node.tag_and_index & 3u, lower = node.tag_and_index >> 2;
    for (int a = 0; a < 3; ++a) {
      voxels.lower[a][1 - only] = voxels.lower[a][only];
      voxels.upper[a][1 - only] = voxels.upper[a][only];
    }
    voxels.upper[axis][0] = voxels.lower[axis][1] = node.split;
    voxels.child[0] = lower;
    voxels.child[1] = lower + 1;
    alignas(16) float z_near[kLanes];
    uint32_t met = FrustumTests<kLanes>::boxes(f, voxels, z_near) & 3u;
    for (uint32_t i = 0; i < 2; ++i) {
      const KdNode& child = scene.nodes[lower + i];
      if (is_kd_leaf(child) && child.count == 0) met &= ~(1u << i);
    }
    if (met == 0) return;
    if (met == 3u) {
      list.insert(whole, only);
      return list.write_to(entry);
    }
    only = __builtin_ctz(met);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
