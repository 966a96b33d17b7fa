// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/thesis_tracer.h"

#include <algorithm>
#include <limits>

namespace tessera::bench {

Subtree ThesisTracer::root() const {
  Subtree root;
  for (int a = 0; a < 3; ++a) {
    root.voxel.lower[a] = double{tree_.bounds().lower[a]};
    root.voxel.upper[a] = double{tree_.bounds().upper[a]};
  }
  return root;
}

Subtree ThesisTracer::child(const Subtree& of, bool is_front) const {
  const core::KdNode& node = tree_.nodes()[of.node];
  const int axis = static_cast<int>(node.tag_and_index & 3u);
  const bool is_lower = is_front != bundle_.goes_down(axis);
  Subtree child = of;
  child.node = (node.tag_and_index >> 2) + (is_lower ? 0 : 1);
  (is_lower ? child.voxel.upper : child.voxel.lower)[axis] = double{node.split};
  return child;
}

void ThesisTracer::count(Side side, ThesisCounts& counts) {
  ++counts.steps;
  if (side == Side::kFront) ++counts.front_only;
  if (side == Side::kBack) ++counts.back_only;
  if (side == Side::kBoth) ++counts.both;
}

void ThesisTracer::test_leaf(const core::KdNode& leaf, ThesisCounts& counts) {
  bundle_.test_leaf(tree_.primitive_refs().data() + (leaf.tag_and_index >> 2), leaf.count,
                    with_details_, counts);
}

void ThesisTracer::trace(Way way, int x_px, int y_px, int edge_px, const Subtree& from,
                         bool with_details, ThesisCounts& counts) {
  if (from.is_empty) {
    ++counts.bundles;
    return;
  }
  with_details_ = with_details;
  if (!bundle_.begin(x_px, y_px, edge_px)) {
    const int half = edge_px / 2;
    for (int i = 0; i < 4 && half > 0; ++i)
      trace(way, x_px + i % 2 * half, y_px + i / 2 * half, half, from, with_details, counts);
    return;  // a ray along an axis is left out
  }
  ++counts.bundles;
  if (way == Way::kMasked) trace_masked(from, counts);
  if (way == Way::kExtremal) trace_extremal(from, counts);
  if (way == Way::kOneSegment) trace_one_segment(from, counts);
}

void ThesisTracer::trace_masked(const Subtree& from, ThesisCounts& counts) {
  struct Pending {
    std::uint32_t node;
    std::vector<Segment> segments;
  };
  const std::size_t n = bundle_.size();
  std::vector<Pending> stack(1, {from.node, std::vector<Segment>(n)});
  for (std::size_t i = 0; i < n; ++i) stack[0].segments[i] = bundle_.clip(i, from.voxel);
  while (!stack.empty()) {
    Pending at = std::move(stack.back());
    stack.pop_back();
    bool is_active = false;
    for (std::size_t i = 0; i < n; ++i) {
      at.segments[i].far = std::min(at.segments[i].far, bundle_.best()[i]);
      is_active |= !at.segments[i].is_empty();
    }
    if (!is_active) continue;
    while (!is_leaf(tree_.nodes()[at.node])) {
      const core::KdNode& node = tree_.nodes()[at.node];
      const int axis = static_cast<int>(node.tag_and_index & 3u);
      const std::uint32_t lower = node.tag_and_index >> 2;
      const bool is_down = bundle_.goes_down(axis);
      const std::uint32_t front = lower + (is_down ? 1 : 0), back = lower + (is_down ? 0 : 1);
      bool to_front = false, to_back = false;
      for (std::size_t i = 0; i < n; ++i) {
        if (at.segments[i].is_empty()) continue;
        const double d = bundle_.distance(i, axis, double{node.split});
        to_front |= d >= at.segments[i].near;
        to_back |= d <= at.segments[i].far;
      }
      count(!to_back ? Side::kFront : !to_front ? Side::kBack : Side::kBoth, counts);
      at.node = to_front ? front : back;
      if (!to_front || !to_back) continue;
      stack.push_back({back, at.segments});
      for (std::size_t i = 0; i < n; ++i) {
        const double d = bundle_.distance(i, axis, double{node.split});
        stack.back().segments[i].near = std::max(at.segments[i].near, d);
        at.segments[i].far = std::min(at.segments[i].far, d);
      }
    }
    test_leaf(tree_.nodes()[at.node], counts);
  }
}

// A ray that has left the voxel before it comes to the plane is in the front child alone; one that
// comes to the plane before it enters the voxel, or starts behind the plane, is in the back child.
ThesisTracer::Side ThesisTracer::side_of(const Subtree& at) const {
  const core::KdNode& node = tree_.nodes()[at.node];
  const int axis = static_cast<int>(node.tag_and_index & 3u);
  bool all_behind = true;
  bool all_left[2] = {true, true}, all_before[2] = {true, true};
  for (const std::size_t ray : bundle_.corners()) {
    const double d = bundle_.distance(ray, axis, double{node.split});
    all_behind = all_behind && d < 0;
    for (int k = 0; k < 2; ++k) {
      const int across = (axis + 1 + k) % 3;
      const double at_plane = bundle_.origin(across) + d * bundle_.direction(ray, across);
      const bool is_down = bundle_.goes_down(across);
      const double sign = is_down ? -1 : 1;
      const double first = is_down ? at.voxel.upper[across] : at.voxel.lower[across];
      const double last = is_down ? at.voxel.lower[across] : at.voxel.upper[across];
      all_left[k] = all_left[k] && (at_plane - last) * sign > 0;
      all_before[k] = all_before[k] && (at_plane - first) * sign < 0;
    }
  }
  if (all_behind || all_before[0] || all_before[1]) return Side::kBack;
  if (all_left[0] || all_left[1]) return Side::kFront;
  return Side::kBoth;
}

void ThesisTracer::trace_extremal(const Subtree& from, ThesisCounts& counts) {
  std::vector<Subtree> stack(1, from);
  while (!stack.empty()) {
    Subtree at = stack.back();
    stack.pop_back();
    bool is_open = false;  // some ray may still find a nearer hit in there
    for (std::size_t i = 0; i < bundle_.size(); ++i) {
      const Segment segment = bundle_.clip(i, at.voxel);
      is_open |= !segment.is_empty() && segment.near < bundle_.best()[i];
    }
    if (!is_open) continue;
    while (!is_leaf(tree_.nodes()[at.node])) {
      const Side side = side_of(at);
      count(side, counts);
      if (side == Side::kBoth) stack.push_back(child(at, false));
      at = child(at, side != Side::kBack);
    }
    test_leaf(tree_.nodes()[at.node], counts);
  }
}

void ThesisTracer::trace_one_segment(const Subtree& from, ThesisCounts& counts) {
  struct Pending {
    std::uint32_t node;
    Segment segment;
  };
  Segment all{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t i = 0; i < bundle_.size(); ++i) {
    const Segment segment = bundle_.clip(i, from.voxel);
    if (segment.is_empty()) continue;
    all = {std::min(all.near, segment.near), std::max(all.far, segment.far)};
  }
  std::vector<Pending> stack(1, {from.node, all});
  while (!stack.empty()) {
    auto [number, segment] = stack.back();
    stack.pop_back();
    const double worst = *std::max_element(bundle_.best().begin(), bundle_.best().end());
    segment.far = std::min(segment.far, worst);
    if (segment.is_empty()) continue;
    while (!is_leaf(tree_.nodes()[number])) {
      const core::KdNode& node = tree_.nodes()[number];
      const int axis = static_cast<int>(node.tag_and_index & 3u);
      const std::uint32_t lower = node.tag_and_index >> 2;
      const bool is_down = bundle_.goes_down(axis);
      double least = std::numeric_limits<double>::infinity(), most = -least;
      for (const std::size_t ray : bundle_.corners()) {
        const double d = bundle_.distance(ray, axis, double{node.split});
        least = std::min(least, d);
        most = std::max(most, d);
      }
      const Side side = most < segment.near   ? Side::kBack
                        : least > segment.far ? Side::kFront
                                              : Side::kBoth;
      count(side, counts);
      if (side == Side::kBoth) {
        stack.push_back({lower + (is_down ? 0 : 1), {std::max(least, segment.near), segment.far}});
        segment.far = std::min(segment.far, most);
      }
      number = lower + ((side != Side::kBack) == is_down ? 1 : 0);
    }
    test_leaf(tree_.nodes()[number], counts);
  }
}

// Whether the tile meets a leaf that is not empty.
bool ThesisTracer::reaches_leaf(const Subtree& at, std::uint64_t& steps) const {
  const core::KdNode& node = tree_.nodes()[at.node];
  if (is_leaf(node)) return node.count > 0;
  ++steps;
  const Side side = side_of(at);
  if (side != Side::kBack && reaches_leaf(child(at, true), steps)) return true;
  return side != Side::kFront && reaches_leaf(child(at, false), steps);
}

// The deepest subtree that holds all leaves met that are not empty.
Subtree ThesisTracer::search(Subtree at, std::uint64_t& steps) const {
  while (true) {
    const core::KdNode& node = tree_.nodes()[at.node];
    if (is_leaf(node)) {
      at.is_empty = node.count == 0;
      return at;
    }
    ++steps;
    const Side side = side_of(at);
    if (side == Side::kBoth) {
      const Subtree front = search(child(at, true), steps);
      if (!front.is_empty) return reaches_leaf(child(at, false), steps) ? at : front;
    }
    at = child(at, side == Side::kFront);
  }
}

Subtree ThesisTracer::find_entry(int x_px, int y_px, int edge_px, const Subtree& from,
                                 std::uint64_t& steps) {
  if (from.is_empty || !bundle_.begin_corners(x_px, y_px, edge_px)) return from;
  return search(from, steps);
}

}  // namespace tessera::bench
