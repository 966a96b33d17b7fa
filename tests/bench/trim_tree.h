// SPDX-License-Identifier: Apache-2.0
// What trims could have had instead of cells (slave/core/decisions/trims.md): a tree of boxes over
// runs of pieces, one after the other along a loop, and over loops. A run whose box a point is not
// in is decided by its two ends, and a loop counts for nothing then, so a point goes down only
// where it lies in boxes. Memory is linear; loops one in the other are all looked at.
//
// Threads. Built by one thread, then never changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slave/core/primitive/patch/trim_cells.h"

namespace tessera::bench {

class TrimTree {
 public:
  // Over all pieces of one patch. Keeps a reference.
  explicit TrimTree(const core::TrimCells& cells);

  // Parity of what a ray from a point towards +u crosses. Adds nodes as cells.
  bool is_odd(double u, double v, core::TrimSteps& steps) const;

  std::size_t bytes() const { return nodes_.size() * sizeof(Node); }

 private:
  struct Node {
    float u[2], v[2];           // box
    float v_from, v_to;         // ends of a run; alike where it is closed
    std::uint32_t left, right;  // children; of a leaf, its piece and 0
  };

  std::uint32_t run(const std::vector<float>& ends, std::uint32_t from, std::uint32_t to);
  std::uint32_t join(std::vector<std::uint32_t>& loops, std::size_t from, std::size_t to);
  std::uint32_t add(const Node& node);
  Node joined(std::uint32_t left, std::uint32_t right) const;

  const core::TrimCells& cells_;
  std::vector<Node> nodes_;
  std::uint32_t root_ = 0;
};

}  // namespace tessera::bench
