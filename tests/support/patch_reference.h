// SPDX-License-Identifier: Apache-2.0
// All roots of a ray in a patch, in extended precision: the oracle that the product's decisions are
// measured against. It shares no code with them: whole patches, plain halving of the net seen along
// the ray in long double, Newton on de Casteljau's scheme.
//
// A box is dropped where the range of one of the two projected polynomials is away from 0 by more
// than 2^-53 of the farthest control point (2^11 roundings of 2^-64; 120 halvings of 15 each).
// Where the range of the Jacobian, times the inverse of its middle, is within 1/8 of the identity,
// a box has one root at most, and Newton finds it. Boxes as small as the noise are fragile roots.
//
// What is asked of an answer, with u = 2^-24 and s the farthest control point from the origin, both
// by axis: a shift of the ray by 16 u s is nothing (float32 rays are no better). A root that such a
// shift may remove is fragile (tangency, cusp: Newton-Kantorovich number of the shift not below
// 1/4), and one that it may move over the border is an edge. t may be off by what a shift of 8 u s
// makes of it.
//
// Threads. An object is one thread's.
#pragma once

#include <cstddef>
#include <vector>

#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_ray.h"

namespace tessera::test {

// A point of a patch and its derivatives, by de Casteljau's scheme.
struct LongJet {
  long double point[3], du[3], dv[3];
};
LongJet long_jet(const core::Patch& patch, long double u, long double v);

struct PatchRoot {
  double t = 0, u = 0, v = 0;
  double allowed_t = 0;
  double by_shift[2] = {};  // what u and v move by at most, by a shift of the ray of length 1
  bool is_fragile = false, is_edge = false;
};

class PatchReference {
 public:
  // Appends the roots in the patch and near its border, at any t.
  void solve(const core::Patch& patch, const core::PatchRay& ray, std::vector<PatchRoot>& roots);

 private:
  using Long = long double;
  struct Net {
    Long f[2][core::kPatchPointsMax];
  };
  struct Span {
    Long low, high;
  };
  struct Place {
    Long u0, u1, v0, v1;
  };

  Span slope(const Long* f, bool by_u) const;
  void cut(Long* f, bool by_u, Long a, bool keeps_high) const;
  void halve(const Net& net, const Place& place, int depth);
  void polish(const Place& place, bool is_cluster);
  void report(Long u, Long v, Long t, bool is_cluster);
  bool is_fragile(Long u, Long v, Long inverse) const;

  core::Patch patch_{};
  int m_ = 0, n_ = 0;
  Long o_[3] = {}, d_[3] = {}, n1_[3] = {}, n2_[3] = {};
  Long far_ = 0, noise_ = 0, tolerance_ = 0;
  std::vector<PatchRoot>* roots_ = nullptr;
  std::size_t first_ = 0;
};

}  // namespace tessera::test
