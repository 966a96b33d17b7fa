// SPDX-License-Identifier: Apache-2.0
// The children that a traversal has still to visit, the nearest on top.
// Threads. One traversal owns one. The stack cannot overflow: a step down pushes at most W - 1
// children, over at most kBvhDepthMax steps, and one child is put back.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_NODE_STACK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_NODE_STACK_INL_H_
#undef TESSERA_CORE_NODE_STACK_INL_H_
#else
#define TESSERA_CORE_NODE_STACK_INL_H_
#endif

#include "slave/core/primitive/leaf-inl.h"
#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct StackEntry {
  uint32_t child;
  float distance;  // at which its box begins
};

struct BelowRoot {};

// Cache lines of a child that are fetched ahead. Packets read the whole of it, and work long on
// each; single rays are faster with few.
constexpr size_t kSomeLines = 4;
template <class View>
constexpr size_t kAllLines = [] {
  constexpr size_t kNode = sizeof(BvhNode<View::kWidth>);
  constexpr size_t kBlock = LeafTests<typename View::Shapes>::kBlockBytes;
  return lines_of(kNode > kBlock ? kNode : kBlock);
}();

// Fetches a child. What lies behind its end may be fetched, too: nodes and blocks are told apart
// without a branch.
template <size_t kLines, class View>
HWY_INLINE void fetch_child(const View& scene, uint32_t child) {
  const bool is_leaf = (child & kBvhLeaf) != 0;
  const char* const at =
      is_leaf ? LeafTests<typename View::Shapes>::address(scene.shapes, child & kBvhBlockMask)
              : reinterpret_cast<const char*>(scene.nodes + child);
  fetch_lines<kLines>(at);
}

// kLines: of a child, fetched when it is pushed.
template <class View, size_t kLines = kSomeLines>
class NodeStack {
  using Node = BvhNode<View::kWidth>;

 public:
  NodeStack() = default;  // of no use before begin()
  explicit NodeStack(const View& scene) { begin(scene); }
  // For a traversal that begins below the root.
  NodeStack(const View& scene, BelowRoot) : scene_(&scene) {}

  // Leaves nothing but the root, of a scene that has one.
  HWY_INLINE void begin(const View& scene) {
    scene_ = &scene;
    size_ = 0;
    if (scene.nodes != nullptr) put_back(0);
  }

  // The nearest child that begins at `far` or before it; kBvhNoChild where there is none.
  HWY_INLINE uint32_t next(float far) {
    while (size_ > 0) {
      const StackEntry& entry = entries_[--size_];
      if (entry.distance <= far) return entry.child;
    }
    return kBvhNoChild;
  }

  HWY_INLINE void clear() { size_ = 0; }
  // Adds what is to be visited next, in place of the child that was taken last.
  HWY_INLINE void put_back(uint32_t child) { entries_[size_++] = {child, -__builtin_inff()}; }

  // Returns: the nearest of the children, which is not pushed as the others are; kBvhNoChild
  // without any.
  uint32_t descend(const Node& node, uint32_t bits, const float* distances) {
    if (bits == 0) return kBvhNoChild;
    const int first = __builtin_ctz(bits);
    bits &= bits - 1;
    if (bits == 0) return node.child[first];
    StackEntry nearest{node.child[first], distances[first]};
    const int base = size_;
    for (; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      StackEntry entry{node.child[i], distances[i]};
      if (entry.distance < nearest.distance) {
        const StackEntry nearer = entry;
        entry = nearest;
        nearest = nearer;
      }
      insert(entry, base);
    }
    return nearest.child;
  }

  // Does what descend() does, in any order: where one hit is as good as another, sorting costs more
  // than it saves.
  uint32_t descend_unsorted(const Node& node, uint32_t bits) {
    if (bits == 0) return kBvhNoChild;
    const int first = __builtin_ctz(bits);
    for (bits &= bits - 1; bits != 0; bits &= bits - 1) {
      const uint32_t child = node.child[__builtin_ctz(bits)];
      fetch_child<kLines>(*scene_, child);
      entries_[size_++] = {child, -__builtin_inff()};
    }
    return node.child[first];
  }

 private:
  // Keeps the entries from `base` on sorted.
  HWY_INLINE void insert(const StackEntry& entry, int base) {
    fetch_child<kLines>(*scene_, entry.child);
    int at = size_++;
    for (; at > base && entries_[at - 1].distance < entry.distance; --at) {
      entries_[at] = entries_[at - 1];
    }
    entries_[at] = entry;
  }

  const View* scene_ = nullptr;
  StackEntry entries_[kBvhDepthMax * (View::kWidth - 1) + 1];
  int size_ = 0;
};

HWY_INLINE uint32_t leaf_first(uint32_t child) { return child & kBvhBlockMask; }
HWY_INLINE uint32_t leaf_count(uint32_t child) {
  return (child >> kBvhCountShift & (kBvhLeafBlocksMax - 1)) + 1;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
