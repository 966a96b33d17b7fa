// SPDX-License-Identifier: Apache-2.0
// The exact answer of one triangle to one ray, for the few rays that a kernel's float32 filter
// leaves open.
//
// The triangle is the closed hull of three float32 points, the ray a float32 half line; whether
// they meet is decided without rounding error, so the answer belongs to the ray and the triangle
// and to no method, bundle or instruction set. Two triangles that share an edge or a vertex see it
// from the same exact numbers: no ray can pass between them. A ray in the plane of a triangle
// misses it.
//
// After J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
// predicates", Discrete & Computational Geometry 18, 1997: double with a bound on its error first,
// expansions where that is not enough.
//
// Declarations only: kernel files, which are compiled once per instruction set, may include this.
// Threads. Pure function.
#pragma once

namespace tessera::core {

// Relative to the sizes of its terms, how far p.(q x r) is off at most in double from operands that
// are rounded themselves: each term has 3 roundings of operands, 2 of products, 1 of the
// difference, 2 of the sum; 16 leaves room for the bound's own.
inline constexpr double kDeterminantError = 16 * 0x1p-53;

struct ExactHit {
  bool is_hit;
  float t;  // where the line meets the plane, to 2 roundings; also behind the origin
};

// Whether a triangle has an area, by its edges in double, where differences are nearly always
// exact. No ray meets a triangle without area; among those are slivers whose area is lost even in
// double.
// Shape: triangle [9] (A, B, C).
bool has_area(const float* triangle);

// Shape: origin [3], direction [3], triangle [9] (A, B, C); finite, direction not zero.
ExactHit exact_hit(const float* origin, const float* direction, const float* triangle);

// Whether exact_hit() is a hit, for callers that know t.
bool is_exact_hit(const float* origin, const float* direction, const float* triangle);

// The side of the triangle's plane that the origin lies on: 1 behind, where A, B, C turn clockwise,
// -1 in front, 0 in the plane. Exact; shapes as above.
int exact_side(const float* origin, const float* triangle);

}  // namespace tessera::core
