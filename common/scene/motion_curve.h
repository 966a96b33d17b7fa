// SPDX-License-Identifier: Apache-2.0
// Values of animation channels between their keys (glTF 2.0, section 3.11 and appendix C), in
// double and by additions, multiplications, divisions and square roots alone, so that they have the
// same bits on every machine: sines are sums of their series here.
// Threads. Pure functions.
#pragma once

#include <array>
#include <span>

#include "common/scene/animation.h"

namespace tessera {

using Quaternion = std::array<double, 4>;  // x, y, z, w

// The quaternion at length 1; no rotation where its length is 0 or not finite.
Quaternion unit(const Quaternion& q);

// The rotation a share of the way from `a` to `b` along the shorter great arc, of length 1. It is
// off by less than 1e-15 in each component. Requires: unit quaternions; a share in [0, 1].
Quaternion slerp(const Quaternion& a, const Quaternion& b, double share);

// Writes the value at a time; rotations at length 1. Requires: a validated animation;
// value.size() is value_width().
void sample_channel(const SceneAnimation& animation, const MotionChannel& channel, double seconds,
                    std::span<double> value);

}  // namespace tessera
