// SPDX-License-Identifier: Apache-2.0
// How flat a ray may leave a point of a primitive and still be known not to meet that primitive
// again: the sine of its angle to the primitive's tangent plane, from which on it is known.
// Fixed-size types only and no functions.
//
// What is known holds but for the rounding of where the ray begins: a hit within that rounding,
// divided by kHorizonRoom, is the point that the ray has left.
#pragma once

namespace tessera::core {

// Of planes. The normal as computed is off by less than 2^-14 where a triangle is no sliver, of
// which nothing is known; see vpl_gather-inl.h.
inline constexpr float kPlaneHorizon = 0x1p-12f;
// What curved primitives have beside what is derived for them.
inline constexpr float kHorizonRoom = 0x1p-6f;
// Where nothing is known: no ray is as steep.
inline constexpr float kNoHorizon = 2;

}  // namespace tessera::core
