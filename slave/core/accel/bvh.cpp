// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh.h"

#include <string>

#include "slave/core/accel/bvh_children.h"

namespace tessera::core {
namespace {

Status broken(std::size_t node, const char* what) {
  return Status::internal("hierarchy node " + std::to_string(node) + ": " + what);
}

bool holds(const Bounds3f& outer, const Bounds3f& inner) {
  for (int a = 0; a < 3; ++a) {
    if (inner.lower[a] < outer.lower[a] || inner.upper[a] > outer.upper[a]) return false;
  }
  return true;
}

template <int W>
class Validator {
 public:
  Validator(const Bvh<W>& bvh, const PrimitiveSet& set, const PrimitiveClipper* clipper)
      : bvh_(bvh),
        clipper_(clipper),
        leaves_(set.leaves),
        boxes_(set.boxes),
        depth_(bvh.nodes.size(), -1),
        listed_(set.boxes.size(), 0) {}

  Status run() {
    if (!bvh_.nodes.empty()) {
      depth_[0] = 0;
      limits_.assign(bvh_.nodes.size(), bvh_.bounds);
    }
    for (std::size_t n = 0; n < bvh_.nodes.size(); ++n) {
      if (depth_[n] < 0) return broken(n, "has no parent in front of it");
      if (depth_[n] > kBvhDepthMax) return broken(n, "lies too deep");
      for (int slot = 0; slot < W; ++slot) TESSERA_RETURN_IF_ERROR(check_child(n, slot));
    }
    for (std::size_t p = 0; p < boxes_.size(); ++p) {
      const int least = boxes_[p].is_empty() ? 0 : 1;
      const bool is_often = clipper_ != nullptr && least == 1;
      if (listed_[p] < least || (listed_[p] > least && !is_often)) {
        return Status::internal("primitive " + std::to_string(p) + " is listed " +
                                std::to_string(listed_[p]) + " times");
      }
    }
    return Status::ok();
  }

 private:
  Status check_child(std::size_t n, int slot) {
    const std::uint32_t child = bvh_.nodes[n].child[slot];
    const Bounds3f box = child_box(bvh_.nodes[n], slot);
    if (child == kBvhNoChild) {
      return box.is_empty() ? Status::ok() : broken(n, "has a box without a child");
    }
    if (!holds(limits_[n], box)) return broken(n, "a child is larger than its parent");
    if ((child & kBvhLeaf) != 0) return check_leaf(n, child, box);
    if (child <= n || child >= bvh_.nodes.size()) return broken(n, "a child is out of range");
    if (depth_[child] >= 0) return broken(n, "a child has two parents");
    depth_[child] = depth_[n] + 1;
    limits_[child] = box;
    return Status::ok();
  }

  Status check_leaf(std::size_t n, std::uint32_t child, const Bounds3f& box) {
    const std::uint32_t first = first_block_of(child), count = block_count_of(child);
    if (first + count > leaves_.block_count()) return broken(n, "a leaf is out of range");
    std::int64_t last = -1;
    for (std::uint32_t b = first; b < first + count; ++b) {
      for (const std::uint32_t p : leaves_.primitives_of(b)) {
        if (p >= boxes_.size()) return broken(n, "a primitive is out of range");
        if (p <= last) return broken(n, "primitives do not ascend");
        if (!is_in(box, p)) return broken(n, "a primitive is larger than its leaf");
        ++listed_[p];
        last = p;
      }
    }
    return Status::ok();
  }

  // A primitive that was cut need only touch its leaves' boxes.
  bool is_in(const Bounds3f& box, std::uint32_t p) const {
    if (clipper_ == nullptr) return holds(box, boxes_[p]);
    return !Bounds3f{max(box.lower, boxes_[p].lower), min(box.upper, boxes_[p].upper)}.is_empty();
  }

  const Bvh<W>& bvh_;
  const PrimitiveClipper* const clipper_;
  const LeafWriter& leaves_;
  std::span<const Bounds3f> boxes_;
  std::vector<int> depth_;
  std::vector<int> listed_;
  std::vector<Bounds3f> limits_;
};

}  // namespace

template <int W>
Status Bvh<W>::validate(const PrimitiveSet& set, const PrimitiveClipper* clipper) const {
  return Validator<W>(*this, set, clipper).run();
}

template struct Bvh<8>;
template struct Bvh<16>;

}  // namespace tessera::core
