// SPDX-License-Identifier: Apache-2.0
// How flat a ray may leave a point of a primitive and still be known not to meet that primitive
// again: the sine of its angle to the primitive's tangent plane, above which it is known. A ray
// that ends at the point is seen from there.
//
// Of curved primitives this holds but for the rounding of where the ray begins: what it meets
// nearby is the point that it has left (slave/core/primitive/patch/patch_horizon.h).
// Fixed-size types only and no functions.
#pragma once

namespace tessera::core {

// Of planes, whose normal as computed is off by less than 2^-14; see vpl_gather-inl.h.
inline constexpr float kPlaneHorizon = 0x1p-12f;
// Where nothing is known: no ray is as steep.
inline constexpr float kNoHorizon = 2;

}  // namespace tessera::core
