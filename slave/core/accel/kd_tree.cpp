// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_tree.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/base/check.h"

namespace tessera::core {
namespace {

bool overlaps_interior(const Bounds3f& box, const Bounds3f& voxel) {
  for (int a = 0; a < 3; ++a) {
    if (!(box.lower[a] < voxel.upper[a] && box.upper[a] > voxel.lower[a])) return false;
  }
  return true;
}

bool touches(const Bounds3f& box, const Bounds3f& voxel) {
  for (int a = 0; a < 3; ++a) {
    if (!(box.lower[a] <= voxel.upper[a] && box.upper[a] >= voxel.lower[a])) return false;
  }
  return true;
}

void set_axis(Vec3f& v, int axis, float value) {
  (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
}

Status broken(const char* what, std::size_t node) {
  return Status::internal("kd-tree node " + std::to_string(node) + ": " + what);
}

struct Visit {
  std::uint32_t node;
  int depth;
  Bounds3f voxel;
  std::vector<std::uint32_t> inside;  // primitives that overlap the voxel's interior
};

}  // namespace

KdTree::KdTree(const Bounds3f& bounds, std::vector<KdNode> nodes,
               std::vector<std::uint32_t> primitive_refs)
    : bounds_(bounds), nodes_(std::move(nodes)), primitive_refs_(std::move(primitive_refs)) {
  TESSERA_CHECK(!nodes_.empty());
}

Status KdTree::validate(std::span<const Bounds3f> boxes, bool is_clipped) const {
  std::vector<bool> is_reached(nodes_.size(), false), is_listed(boxes.size(), false);
  std::vector<Visit> open(1);
  open[0] = {0, 0, bounds_, {}};
  for (std::uint32_t p = 0; p < boxes.size(); ++p) {
    if (!boxes[p].is_empty() && overlaps_interior(boxes[p], bounds_)) open[0].inside.push_back(p);
  }
  while (!open.empty()) {
    const Visit visit = std::move(open.back());
    open.pop_back();
    if (is_reached[visit.node]) return broken("has two parents", visit.node);
    is_reached[visit.node] = true;
    const KdNode& node = nodes_[visit.node];
    const std::uint32_t tag = node.tag_and_index & 3u, index = node.tag_and_index >> 2;
    if (tag == kKdLeafTag) {
      if (visit.depth > kKdDepthMax) return broken("too deep", visit.node);
      if (std::uint64_t{index} + node.count > primitive_refs_.size())
        return broken("refs", visit.node);
      const auto first = primitive_refs_.begin() + index, last = first + node.count;
      if (!std::is_sorted(first, last)) return broken("refs not ascending", visit.node);
      for (auto it = first; it != last; ++it) {
        if (*it >= boxes.size() || boxes[*it].is_empty())
          return broken("foreign primitive", visit.node);
        if (!touches(boxes[*it], visit.voxel)) return broken("primitive outside", visit.node);
        is_listed[*it] = true;
      }
      for (const std::uint32_t p : visit.inside) {
        if (!is_clipped && !std::binary_search(first, last, p))
          return broken("primitive missing", visit.node);
      }
      continue;
    }
    const int axis = static_cast<int>(tag);
    if (index <= visit.node || index + 1 >= nodes_.size()) return broken("child index", visit.node);
    if (!(node.split > visit.voxel.lower[axis] && node.split < visit.voxel.upper[axis])) {
      return broken("split outside its voxel", visit.node);
    }
    for (std::uint32_t side = 0; side < 2; ++side) {
      Visit child{index + side, visit.depth + 1, visit.voxel, {}};
      set_axis(side == 0 ? child.voxel.upper : child.voxel.lower, axis, node.split);
      for (const std::uint32_t p : visit.inside) {
        if (overlaps_interior(boxes[p], child.voxel)) child.inside.push_back(p);
      }
      open.push_back(std::move(child));
    }
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!is_reached[n]) return broken("not reached", n);
  }
  for (std::size_t p = 0; p < boxes.size(); ++p) {
    if (!boxes[p].is_empty() && !is_listed[p]) {
      return Status::internal("primitive " + std::to_string(p) + " is in no leaf");
    }
  }
  return Status::ok();
}

double KdTree::sah_cost(double cost_traverse, double cost_intersect) const {
  struct Part {
    std::uint32_t node;
    Bounds3f voxel;
  };
  const auto half_area = [](const Bounds3f& box) {
    const Vec3f e = box.extent();
    return double{e.x} * e.y + double{e.y} * e.z + double{e.z} * e.x;
  };
  double cost = 0;
  std::vector<Part> open{{0, bounds_}};
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    const KdNode& node = nodes_[part.node];
    const std::uint32_t tag = node.tag_and_index & 3u, index = node.tag_and_index >> 2;
    if (tag == kKdLeafTag) {
      cost += half_area(part.voxel) * cost_intersect * node.count;
      continue;
    }
    cost += half_area(part.voxel) * cost_traverse;
    for (std::uint32_t side = 0; side < 2; ++side) {
      Part child{index + side, part.voxel};
      set_axis(side == 0 ? child.voxel.upper : child.voxel.lower, static_cast<int>(tag),
               node.split);
      open.push_back(child);
    }
  }
  const double all = half_area(bounds_);
  return all > 0 ? cost / all : cost_intersect * static_cast<double>(primitive_refs_.size());
}

}  // namespace tessera::core
