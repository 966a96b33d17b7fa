// SPDX-License-Identifier: Apache-2.0
// The answer of one triangle to one ray in rational arithmetic: the oracle that the product's
// exact_hit() and all kernels are measured against. It shares no code with them, and computes by
// other formulas (T. Moeller, B. Trumbore, "Fast, minimum storage ray/triangle intersection",
// Journal of Graphics Tools 2, 1997) on integers of any length. It is slow and simple.
//
// The rules are the product's: the triangle is the closed hull of its corners; a line in its plane
// misses it; a triangle without area is never hit, and it has none where its edges, rounded to
// double, have a cross product of zero when each of its products is rounded to double.
//
// Threads. Pure functions.
#pragma once

namespace tessera::test {

struct RationalHit {
  bool is_hit = false;
  long double t = 0;  // of a hit: where the line meets the plane, to 2^-61
};

// Shape: origin [3], direction [3], triangle [9] (A, B, C); finite.
RationalHit rational_hit(const float* origin, const float* direction, const float* triangle);

// The t that every kernel reports for a hit, by the definition in plane-inl.h, whose operations in
// double and float32 are stated here once more. Where that definition leaves t to exact_hit(), it
// is what exact_hit() says.
struct DefinedT {
  float t = 0;
  bool is_of_plane = false;  // by the operations in double; else by exact_hit()
};
// Requires: the ray hits the triangle. Shapes as above.
DefinedT defined_t(const float* origin, const float* direction, const float* triangle);

// Whether a defined t is as near to that of a rational hit as is promised: 3 roundings and 2^-25
// where it is of the plane (plane-inl.h), else one rounding and the two operands' 2^-30
// (exact_hit.cpp); half of the least float where it is denormal.
bool is_near(const DefinedT& defined, long double t);

}  // namespace tessera::test
