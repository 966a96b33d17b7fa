// SPDX-License-Identifier: Apache-2.0
// The horizon of a point of a sub-patch: the sine of the angle to the tangent plane above which
// rays that leave the point do not meet the sub-patch again, but for the rounding of where they
// begin.
//
// With P = S(u0, v0) and x, y in [0, 1] over the sub-patch, the numerator of S(x, y) - P is
//   G(x, y) = a(x, y) (x - x0) + b(y) (y - y0)
// with divided differences a and b, which are polynomials: their values lie in the hulls of their
// nets a_ij, b_k (L. Schumaker, Spline Functions: Basic Theory, 3rd ed., 2007, section 2.8). Where
// a ray from P along d met the surface again, G = s d would hold with (x, y) other than (x0, y0)
// and s > 0. So (a x b) d s = (a x b) G = 0, which no d with (a_ij x b_k) d > 0 for all i, j, k
// allows, nor one with all below 0. All of these lie within an angle of the normal n, or of -n: its
// sine is the horizon.
//
// Seen from outside, a convex surface hides nothing of the sky: with second divided differences,
//   n G = alpha(x, y) (x - x0)^2 + beta(y) (x - x0) (y - y0) + gamma(y) (y - y0)^2
// is negative where alpha and gamma are, and beta^2 < 4 alpha gamma, for all of their nets. Then
// the horizon is 0.
//
// kHorizonRoom is added to both. A ray that begins at P + e instead meets the surface at t with
// (a x b) (e + t d) = 0, hence |t d| <= |e| / sin(angle between d and the cone's border), no more
// than |e| / kHorizonRoom; from a convex surface, whose height n G is below |e| and as much as n is
// off times |e + t d|, it is as far.
//
// Threads. Pure functions.
#pragma once

#include <optional>

#include "common/math/vec3.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// Of degrees up to this one: others have none.
inline constexpr int kHorizonDegreeMax = 3;
// What is added to the sine.
inline constexpr float kHorizonRoom = 0x1p-6f;

// Of the point S(u, v), for rays on the side of the normal. The point, u, v and the normal may be
// rounded to float32. Returns: nothing where nothing is known, and for spans of widened borders,
// which stand for more than the patch (fat_border.h).
// Requires: (u, v) is within the sub-patch's range, but for rounding; a unit normal.
std::optional<float> horizon_at(const Patch& patch, const SubPatch& part, float u, float v,
                                Vec3f point, Vec3f normal);

}  // namespace tessera::core
