// SPDX-License-Identifier: Apache-2.0
// Rational Bezier patches, and the parts of them that rays are decided on.
// Fixed-size types only and no functions.
//
// A patch is S(u, v) = sum B_i^m(u) B_j^n(v) w_ij P_ij / sum B_i^m(u) B_j^n(v) w_ij on [0, 1]^2
// (G. Farin, Curves and Surfaces for CAGD, 5th ed., 2002, chapters 5, 13, 14). Points P_ij and
// weights w_ij are numbers of float32, so their products are exact in double (24 + 24 bits of 53).
//
// A sub-patch has a frame in which its part of S is nearly the square [-1, 1]^2 of its own
// parameters: with local = frame (P - centre),
//   S(x, y) = (x, y, 0) + rest(x, y),  |rest_k| <= reach_k  for all |x|, |y| <= 1 + kSquareWiden,
// and `second` bounds |S_xx|, |S_xy|, |S_yy| there, by component. So it is a parallelepiped with
// its part of the surface inside (W. Barth, R. Lieger, M. Schindler, "Ray tracing general
// parametric surfaces using interval arithmetic", The Visual Computer 10, 1994). Bounds are of S in
// the frame as it is stored, hence the frame may be any numbers.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kPatchDegreeMax = 15;
inline constexpr int kPatchPointsMax = (kPatchDegreeMax + 1) * (kPatchDegreeMax + 1);
// A sub-patch is [column, column + 1] / 2^level_u by [row, row + 1] / 2^level_v.
inline constexpr int kSubPatchLevelMax = 15;

// How far beyond its square, in units of half its width, the bounds of a sub-patch hold.
inline constexpr double kSquareWiden = 0x1p-20;

class TrimSet;

// w x, w y, w z, w of a control point: what patches are computed with.
struct PatchPoint {
  double x[4];
};

// The numbers are owned elsewhere: x, y, z of each control point, and w where it is rational.
// Control point (i, j), of B_i(u) B_j(v), is number (degree_v + 1) i + j.
struct Patch {
  const float* numbers;
  double extent;               // of the box of all P_ij: its longest side
  uint8_t degree_u, degree_v;  // 1 to kPatchDegreeMax
  bool is_rational;            // else all weights are 1
  // What is kept of it, and its number there; null: all of it.
  const TrimSet* trims = nullptr;
  uint32_t trimmed_as = 0;
};

struct SubPatch {
  float frame[3][3];   // rows a, b, n
  float centre[3];     // in world space
  float reach[3];      // of the rest, by row of the frame
  float second[3][3];  // of the derivatives xx, xy, yy, by row of the frame
  uint32_t patch;      // its number
  uint32_t primitive;  // its own number among those that rays ask for
  uint16_t column, row;
  uint8_t level_u, level_v;
  bool has_frame;   // else only the complete solver decides
  bool is_trimmed;  // some of it may be left out; else hits need not ask
};

}  // namespace tessera::core
