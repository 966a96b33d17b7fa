// SPDX-License-Identifier: Apache-2.0
// The random choices that tests of hard cases make.
//
// Threads. Owned by one test.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "common/math/vec3.h"
#include "tests/support/seed.h"

namespace tessera::test {

class Choices {
 public:
  explicit Choices(unsigned usual_seed) : random_(seed(usual_seed)) {}

  float share() { return std::uniform_real_distribution<float>(0, 1)(random_); }
  float sign() { return 2 * share() - 1; }
  unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }
  bool one_in(unsigned count) { return below(count) == 0; }
  float power(float low, float high) { return std::pow(10.0f, low + (high - low) * share()); }
  Vec3f point(float size) { return {size * sign(), size * sign(), size * sign()}; }
  // A point up to 2^5 roundings away.
  Vec3f beside(Vec3f p) {
    const float largest = std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    return p + point(largest * 0x1p-24f * static_cast<float>(1u << below(6)));
  }

 private:
  std::mt19937 random_;
};

}  // namespace tessera::test
