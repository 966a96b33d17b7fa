// SPDX-License-Identifier: Apache-2.0
// The answer of every triangle to a ray in double precision, without any spatial index. The kernels
// are measured against it. It is slow and simple.
//
// With u = 2^-24 and s the distance of the triangle's farthest vertex from the origin, a ray surely
// hits (misses) when it passes inside (outside) by more than 16 u s, perpendicular to the ray;
// closer to the border either answer is right.
#pragma once

#include <cstdint>
#include <vector>

#include "common/math/vec3.h"

namespace tessera::test {

struct Ray {
  Vec3f origin, direction;
  float t_min = 0, t_max = 0;
};

enum class Verdict : std::uint8_t { kMiss, kEdge, kHit };

struct ReferenceAnswer {
  Verdict verdict = Verdict::kMiss;
  double t = 0;        // of the plane
  double t_error = 0;  // what float32 may be off: 16 u s / (|D| cos)
};

struct ReferenceTriangle {
  Vec3f a, b, c;
};

ReferenceAnswer reference_hit(const Ray& ray, const ReferenceTriangle& triangle);

// Returns: nullptr when (is_hit, primitive, t) is a right answer for the ray, else what is wrong.
const char* judge(const Ray& ray, const std::vector<ReferenceTriangle>& triangles, bool is_hit,
                  std::uint32_t primitive, float t);

}  // namespace tessera::test
