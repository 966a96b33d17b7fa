// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh_fit.h"

#include <algorithm>
#include <new>
#include <string>

#include "slave/core/accel/bvh_children.h"
#include "slave/core/accel/run_tasks.h"

namespace tessera::core {
namespace {

// Leaves are fitted in parts of so many nodes.
constexpr std::size_t kFitPart = 256;

template <int W>
void set_box(BvhNode<W>& node, int slot, const Bounds3f& box) {
  for (int a = 0; a < 3; ++a) {
    node.lower[a][slot] = box.lower[a];
    node.upper[a][slot] = box.upper[a];
  }
}

// Slots without a child do not count, for their boxes are empty.
template <int W>
Bounds3f node_box(const BvhNode<W>& node) {
  const auto least = [](const float(&row)[W]) { return *std::min_element(row, row + W); };
  const auto most = [](const float(&row)[W]) { return *std::max_element(row, row + W); };
  return {{least(node.lower[0]), least(node.lower[1]), least(node.lower[2])},
          {most(node.upper[0]), most(node.upper[1]), most(node.upper[2])}};
}

double half_area(const Bounds3f& box) {
  if (box.is_empty()) return 0;
  const Vec3f e = box.extent();
  return double{e.x} * e.y + double{e.y} * e.z + double{e.z} * e.x;
}

template <int W>
void fit_leaves(const LeafFitter& leaves, BvhNode<W>& node) {
  for (int slot = 0; slot < W; ++slot) {
    const std::uint32_t child = node.child[slot];
    if (!is_bvh_leaf(child)) continue;
    set_box(node, slot, leaves.fit({first_block_of(child), block_count_of(child)}).bounds());
  }
}

template <int W>
Result<Bvh<W>> fit(const Bvh<W>& built, const LeafFitter& leaves, const BuildControl& control) {
  Bvh<W> fitted = built;
  const std::size_t count = fitted.nodes.size();
  run_tasks(static_cast<int>(count / kFitPart) + 1, control.thread_count, [&](int i) {
    if (control.is_to_stop()) return;
    const std::size_t begin = static_cast<std::size_t>(i) * kFitPart;
    const std::size_t end = std::min(begin + kFitPart, count);
    for (std::size_t n = begin; n < end; ++n) fit_leaves(leaves, fitted.nodes[n]);
  });
  if (control.is_to_stop()) return Status::cancelled("the fit of the spatial index was cancelled");
  // Parents stand in front of their children, so the last node is done first.
  for (std::size_t n = count; n-- > 0;) {
    if (n % kFitPart == 0) give_way();
    BvhNode<W>& node = fitted.nodes[n];
    for (int slot = 0; slot < W; ++slot) {
      const std::uint32_t child = node.child[slot];
      if (child != kBvhNoChild && !is_bvh_leaf(child))
        set_box(node, slot, node_box(fitted.nodes[child]));
    }
  }
  if (count > 0) fitted.bounds = node_box(fitted.nodes[0]);
  return fitted;
}

}  // namespace

template <int W>
double sah_cost(const Bvh<W>& bvh) {
  double sum = 0;
  for (const BvhNode<W>& node : bvh.nodes) {
    for (int slot = 0; slot < W; ++slot) {
      const std::uint32_t child = node.child[slot];
      if (child == kBvhNoChild) continue;
      const std::uint32_t tests = is_bvh_leaf(child) ? block_count_of(child) : 1;
      sum += half_area(child_box(node, slot)) * tests;
    }
  }
  const double whole = half_area(bvh.bounds);
  return whole > 0 ? sum / whole : 0;
}

template <int W>
Result<Bvh<W>> fit_bvh(const Bvh<W>& built, const LeafFitter& leaves, const BuildControl& control) {
  try {
    return fit(built, leaves, control);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory to fit a spatial index of " +
                                      std::to_string(built.nodes.size()) + " nodes");
  }
}

template double sah_cost<8>(const Bvh<8>&);
template double sah_cost<16>(const Bvh<16>&);
template Result<Bvh<8>> fit_bvh<8>(const Bvh<8>&, const LeafFitter&, const BuildControl&);
template Result<Bvh<16>> fit_bvh<16>(const Bvh<16>&, const LeafFitter&, const BuildControl&);

}  // namespace tessera::core
