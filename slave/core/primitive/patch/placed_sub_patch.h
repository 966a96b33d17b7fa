// SPDX-License-Identifier: Apache-2.0
// Sub-patches brought to another place by an affine map, so that a surface that stands many times
// is split once.
//
// A patch in the world is the exact one of its control points there, which are rounded to float32:
// S' = M S + E, where E is the patch of the roundings e_ij. In a sub-patch's frame F with centre c,
// L(P) = F (P - c) is (x, y, 0) + rest; in the world the frame is F' = F M^-1 rounded to float32,
// so F' M = (1 + G) F with a small matrix G, and with c' = M c rounded
//   F' (S' - c') = L + G L + F' (M c - c') + F' E.
// Hence the rest grows by at most sum_k |G_rk| |L_k| + |F' (M c - c')|_r + sum_k |F'_rk| e_k, and
// second derivatives by sum_k |G_rk| second_k + sum_k |F'_rk| e''_k. G is that of the numbers as
// they are stored, in double: with J about F^-1 and F J = 1 + D, F' M F^-1 is within |F' M J| |D|
// (1 + 2^-10) of F' M J where D is small, and roundings are added by the sizes of what is summed.
//
// Roundings of points. float32 makes 4 of each coordinate, so e_k = gamma(4) (sum |M_kj| |P_j| +
// |M_k3|), and what underflows. Derivatives of E: with all |e_ij| <= e, weights that differ by a
// factor of rho at most, and degree d, |E'| <= 4 d rho e and |E''| <= 24 d^2 rho^2 e by a parameter
// of [0, 1] (differences of the numerators, the quotient rule, and |w'| <= 2 d w_max), hence times
// half widths in the square, and by the factors of kBeyond beyond it.
//
// Threads. Pure functions.
#pragma once

#include "common/math/bounds3.h"
#include "common/math/transform.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// A map, and what it does to a patch.
class PatchPlacement {
 public:
  explicit PatchPlacement(const Transform& to_world);

  // Must be called before parts of a patch are placed. The patch is in its own place; placed_box
  // holds it in the world.
  void take(const Patch& patch, const Bounds3f& placed_box);
  // Shape: `box`, of the part in its own place, becomes one of it in the world. A part whose frame
  // is lost (by a map that is flat, or beyond float32) is left to the complete solver.
  SubPatch placed(const SubPatch& part, Bounds3f& box) const;

 private:
  struct Frames;

  bool place_frame(const Frames& frames, SubPatch& to) const;
  void widen(const Frames& frames, const SubPatch& part, SubPatch& to) const;
  Bounds3f placed_box(const Bounds3f& box) const;
  void cut_to_parallelepiped(const Frames& frames, const SubPatch& part, Bounds3f& box) const;

  double m_[3][4], inverse_[3][3];
  bool is_regular_;
  // Of the patch at hand:
  double off_[3] = {};  // e
  double ratio_ = 1;    // rho
  int degree_ = 1;      // the larger one
  Bounds3f patch_box_;
};

}  // namespace tessera::core
