// SPDX-License-Identifier: Apache-2.0
// All roots of one ray in one sub-patch, whatever the surface does there, with bounded work: for
// what the usual decision leaves open (silhouettes, cusps, collapsed borders, rays in the surface).
//
// Two planes through the ray, N_1 and N_2, make F = (N_1 . (X - O w), N_2 . (X - O w)) with
// X = w S: two polynomials over the sub-patch in Bernstein form, with the roots of the rational
// patch. Boxes begin with the whole square, widened by kSquareWiden:
// 1. A box where the range of F_1 or F_2 is away from 0 by more than the noise has no root.
// 2. Where both ranges are within `flat`, the box is a root: all of it is as near to the ray as
//    anything that is told apart. A collapsed border ends here, after as many halves of its length
//    as it takes: size in space counts, so u need not be found where S does not depend on it.
// 3. With Y the inverse of the middle of the range of F', the range of Y F - identity narrows the
//    box (Krawczyk's operator with ranges of nets instead of interval derivatives, which
//    B. Mourrain, J.-P. Pavone, "Subdivision methods for solving polynomial equations", Journal of
//    Symbolic Computation 44, 2009, call preconditioned reduction), and |1 - Y F'| <= r.
// 4. r <= 1/4: one root at most, and Newton, clamped, finds it: a step shrinks the error by
//    2 r / (1 - r) <= 2/3, and quadratically in the end (subdivision with such a test:
//    G. Srijuntongsiri, S. Vavasis, "A condition number analysis of a line-surface intersection
//    algorithm", SIAM J. Sci. Comput. 30, 2008).
// 5. A box that shrank below 0.7 is restricted; one that did not is halved, across the side that is
//    longer in space.
//
// Noise. Control points are relative to the origin of the ray by exact products, so errors are
// relative to R, the farthest of them by axis. Planes and products make 10 roundings of
// sqrt(3) R w; a cut costs 45 of the net's size (15 steps of 3), and a box is cut twice at most
// before one of its sides is 0.7 of what it was. Nets with roots are no larger than their
// variation, so sizes fall by 0.7 in two steps: 2 x 90 / (1 - 0.7) = 600 roundings, and 1024
// sqrt(3) 2^-53 R w < 2^-42 R w stand for all. `flat` is 2^-32 of the patch's extent and twice the
// noise: a hundredth of what roundings of the ray to float32 move it by.
//
// Work. At most kBoxesMax boxes. A ray that needs more lies in the surface or is tangent to it
// along a curve; any roundings decide about such a one, and it gets the nearest root found so far.
//
// Threads. An object is one thread's; it is memory to work in (400 KB), and remembers nothing.
#pragma once

#include "slave/core/primitive/patch/cubic_solver_layout.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_ray.h"

namespace tessera::core {

class CompleteSolver {
 public:
  static constexpr int kBoxesMax = kSolverBoxesMax;

  // Returns: the nearest root within t_min and t_max. Requires: a ray of finite numbers whose
  // direction is not zero.
  PatchHit solve(const Patch& patch, const SubPatch& part, const PatchRay& ray);

  // Of the last call: boxes looked at, and whether there were more.
  int box_count() const { return box_count_; }
  bool is_exhausted() const { return is_exhausted_; }

 private:
  static constexpr int kStackMax = 96;  // of halves: 44 in each direction, where width ends
  struct Box {
    double low[2], high[2];  // in the sub-patch's square
    double f[2][kPatchPointsMax];
  };
  struct Jacobian;
  struct Narrowed;

  void set_up(const Patch& patch, const SubPatch& part, const PatchRay& ray);
  void step();
  bool is_elsewhere(const Box& box, bool& is_flat) const;
  Narrowed narrowed(const Box& box, const Jacobian& jacobian) const;
  void halve(int axis);
  void restrict_net(double* f, int axis, double from, double to) const;
  void cut(double* f, int axis, double a, bool keeps_high) const;
  void shrink(Box& box, int axis, double from, double to) const;
  void accept_flat(const Box& box);
  void newton(const Box& box, const Narrowed& to);
  void report(double t, double x, double y);

  Patch shifted_{};                     // its degrees
  PatchPoint points_[kPatchPointsMax];  // of the patch, less the ray's origin
  SubPatch part_{};
  PatchRay ray_{};
  double direction_[3] = {};
  double noise_ = 0, noise_f_ = 0, flat_ = 0;
  PatchHit best_;
  int depth_ = 0, box_count_ = 0;
  bool is_exhausted_ = false;
  Box stack_[kStackMax];
};

}  // namespace tessera::core
