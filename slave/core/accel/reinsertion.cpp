// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/reinsertion.h"

#include <cmath>
#include <vector>

namespace tessera::core {
namespace {

// A move has to save this share of the area of the box above the subtree: less is rounding.
constexpr float kGainMin = 1e-4f;

// A search ends after so many candidates. Where boxes are apart it takes some tens; where all of
// them overlap, every place is as good as any.
constexpr int kCandidatesMax = 512;

// So many searches are made between two questions whether to stop.
constexpr std::uint32_t kSearchesAtOnce = 256;

Box4 united(Box4 a, const Box4& b) {
  a.grow(b);
  return a;
}

bool is_equal(const Box4& a, const Box4& b) {
  const __m128 lower = _mm_cmpneq_ps(a.lower.v, b.lower.v);
  const __m128 upper = _mm_cmpneq_ps(a.upper.v, b.upper.v);
  return (_mm_movemask_ps(_mm_or_ps(lower, upper)) & 7) == 0;
}

class Mover {
 public:
  explicit Mover(std::span<LooseNode> nodes) : nodes_(nodes) {}

  // Moves a subtree to the best place for it. Returns: whether there was a better one.
  bool try_to_move(std::uint32_t moved) {
    if (nodes_[moved].parent == 0) return false;  // the root's halves stay
    const std::uint32_t place = best_place(moved);
    if (place == 0) return false;
    const std::uint32_t parent = nodes_[moved].parent, above = nodes_[parent].parent;
    put_in_place_of(parent, sibling_of(moved));
    fit_from(above);
    put_in_place_of(place, parent);
    nodes_[parent].child[0] = place;
    nodes_[parent].child[1] = moved;
    nodes_[place].parent = parent;
    nodes_[parent].bounds = united(nodes_[place].bounds, nodes_[moved].bounds);
    fit_from(nodes_[parent].parent);
    return true;
  }

 private:
  // A subtree with the best place beside its root or within.
  struct Candidate {
    std::uint32_t node;
    float gain;  // area that boxes above it lose by the move
  };

  std::uint32_t sibling_of(std::uint32_t node) const {
    const LooseNode& parent = nodes_[nodes_[node].parent];
    return parent.child[0] == node ? parent.child[1] : parent.child[0];
  }

  // Returns: the node to stand beside; 0: no place is better than its own. Requires: the node is
  // neither the root nor below it at once.
  std::uint32_t best_place(std::uint32_t moved) {
    const std::uint32_t parent = nodes_[moved].parent;
    const Box4 box = nodes_[moved].bounds;
    const float area = box.half_area(), area_of_parent = nodes_[parent].bounds.half_area();
    float best_gain = area_of_parent * kGainMin;
    std::uint32_t best = 0;
    // What boxes on the way up lose where the subtree leaves them: the parent is no more.
    float saved = area_of_parent;
    Box4 left{};  // in the box on the way up, without the subtree
    int candidates = 0;
    for (std::uint32_t below = moved; below != 0; below = nodes_[below].parent) {
      const std::uint32_t beside = sibling_of(below);
      open_.assign(1, {beside, saved});
      while (!open_.empty() && ++candidates <= kCandidatesMax) {
        const Candidate candidate = open_.back();
        open_.pop_back();
        if (candidate.gain - area <= best_gain) continue;
        const LooseNode& node = nodes_[candidate.node];
        const float gain = candidate.gain - united(node.bounds, box).half_area();
        if (gain > best_gain) {
          best_gain = gain;
          best = candidate.node;
        }
        const float within = gain + node.bounds.half_area();
        if (node.is_leaf() || within - area <= best_gain) continue;
        open_.push_back({node.child[0], within});
        open_.push_back({node.child[1], within});
      }
      left.grow(nodes_[beside].bounds);
      const std::uint32_t above = nodes_[below].parent;
      if (above != parent) saved += nodes_[above].bounds.half_area() - left.half_area();
      if (above == 0) break;
    }
    return best;
  }

  void put_in_place_of(std::uint32_t old_child, std::uint32_t new_child) {
    const std::uint32_t parent = nodes_[old_child].parent;
    LooseNode& node = nodes_[parent];
    (node.child[0] == old_child ? node.child[0] : node.child[1]) = new_child;
    nodes_[new_child].parent = parent;
  }

  // Fits the boxes of an inner node and of those above it, up to the first that fits already.
  void fit_from(std::uint32_t node) {
    for (;; node = nodes_[node].parent) {
      LooseNode& at = nodes_[node];
      const Box4 box = united(nodes_[at.child[0]].bounds, nodes_[at.child[1]].bounds);
      if (is_equal(box, at.bounds)) return;
      at.bounds = box;
      if (node == 0) return;
    }
  }

  const std::span<LooseNode> nodes_;
  std::vector<Candidate> open_;
};

}  // namespace

void reinsert_subtrees(std::span<LooseNode> nodes, int passes,
                       const std::function<bool()>& is_to_stop) {
  // Sums of areas have to be finite, for nothing is more than their difference.
  if (nodes.empty() || !std::isfinite(nodes[0].bounds.half_area() * 1e6f)) return;
  Mover mover(nodes);
  for (int pass = 0; pass < passes; ++pass) {
    bool has_moved = false;
    for (std::uint32_t node = 1; node < nodes.size(); ++node) {
      if (node % kSearchesAtOnce == 0 && is_to_stop()) return;
      has_moved = mover.try_to_move(node) || has_moved;
    }
    if (!has_moved) return;
  }
}

}  // namespace tessera::core
