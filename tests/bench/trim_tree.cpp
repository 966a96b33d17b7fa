// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/trim_tree.h"

#include <algorithm>

#include "common/base/check.h"

namespace tessera::bench {

TrimTree::TrimTree(const core::TrimCells& cells) : cells_(cells) {
  const auto& pieces = cells.pieces;
  const auto goes_up = [&](std::size_t i) {
    const core::TrimParameter a = core::decoded(pieces[i].at[0]),
                              b = core::decoded(pieces[i].at[1]);
    return a.t < b.t || a.s > b.s;
  };
  // [piece]: v where it begins along its loop, then where the last one ends.
  std::vector<float> ends;
  std::vector<std::uint32_t> loops;
  for (std::size_t from = 0; from < pieces.size();) {
    const int first = goes_up(from) ? 0 : 1;
    std::size_t to = from;
    for (bool is_closed = false; !is_closed; ++to) {
      TESSERA_CHECK_LT(to, pieces.size());
      const int begin = goes_up(to) ? 0 : 1;
      ends.push_back(pieces[to].v[begin]);
      is_closed = pieces[to].u[1 - begin] == pieces[from].u[first] &&
                  pieces[to].v[1 - begin] == pieces[from].v[first];
    }
    ends.push_back(ends[from]);
    loops.push_back(run(ends, static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to)));
    ends.pop_back();
    from = to;
  }
  if (!loops.empty()) root_ = join(loops, 0, loops.size());
}

std::uint32_t TrimTree::add(const Node& node) {
  nodes_.push_back(node);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

TrimTree::Node TrimTree::joined(std::uint32_t left, std::uint32_t right) const {
  const Node &a = nodes_[left], &b = nodes_[right];
  return {{std::min(a.u[0], b.u[0]), std::max(a.u[1], b.u[1])},
          {std::min(a.v[0], b.v[0]), std::max(a.v[1], b.v[1])},
          0,
          0,
          left,
          right};
}

std::uint32_t TrimTree::run(const std::vector<float>& ends, std::uint32_t from, std::uint32_t to) {
  if (to - from == 1) {
    const core::TrimPiece& p = cells_.pieces[from];
    return add({{std::min(p.u[0], p.u[1]), std::max(p.u[0], p.u[1])},
                {p.v[0], p.v[1]},
                ends[from],
                ends[to],
                from,
                0});
  }
  const std::uint32_t middle = from + (to - from) / 2;
  const std::uint32_t left = run(ends, from, middle), right = run(ends, middle, to);
  Node node = joined(left, right);
  node.v_from = ends[from];
  node.v_to = ends[to];
  return add(node);
}

std::uint32_t TrimTree::join(std::vector<std::uint32_t>& loops, std::size_t from, std::size_t to) {
  if (to - from == 1) return loops[from];
  Node all = nodes_[loops[from]];
  for (std::size_t i = from; i < to; ++i) {
    const Node& n = nodes_[loops[i]];
    all.u[0] = std::min(all.u[0], n.u[0]);
    all.u[1] = std::max(all.u[1], n.u[1]);
    all.v[0] = std::min(all.v[0], n.v[0]);
    all.v[1] = std::max(all.v[1], n.v[1]);
  }
  const bool by_u = all.u[1] - all.u[0] > all.v[1] - all.v[0];
  const auto place = [&](std::uint32_t loop) {
    const Node& n = nodes_[loop];
    return by_u ? n.u[0] + n.u[1] : n.v[0] + n.v[1];
  };
  const std::size_t middle = from + (to - from) / 2;
  const auto begin = loops.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(from),
                   begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(to),
                   [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  const std::uint32_t left = join(loops, from, middle), right = join(loops, middle, to);
  return add(joined(left, right));
}

bool TrimTree::is_odd(double u, double v, core::TrimSteps& steps) const {
  if (nodes_.empty()) return false;
  std::uint32_t stack[64];
  int size = 0;
  stack[size++] = root_;
  bool is_odd = false;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    ++steps.cells;
    if (v < double{node.v[0]} || v > double{node.v[1]} || u > double{node.u[1]}) continue;
    if (u < double{node.u[0]}) {
      is_odd ^= (double{node.v_from} <= v) != (double{node.v_to} <= v);
    } else if (node.right == 0) {
      ++steps.pieces;
      is_odd ^=
          core::crosses(cells_.pieces[node.left], cells_.coefficients.data(), u, v, steps.points);
    } else {
      stack[size++] = node.left;
      stack[size++] = node.right;
    }
  }
  return is_odd;
}

}  // namespace tessera::bench
