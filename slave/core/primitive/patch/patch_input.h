// SPDX-License-Identifier: Apache-2.0
// Control points as files and scenes have them, checked once and made into a patch's.
// Threads. Pure function.
#pragma once

#include <span>
#include <vector>

#include "common/base/status.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// Shape: numbers [(degree_u + 1) (degree_v + 1)] times x, y, z, or x, y, z, weight where it is
// rational; point (i, j) is number (degree_v + 1) i + j.
struct PatchInput {
  int degree_u = 0, degree_v = 0;
  bool is_rational = false;
  std::span<const float> numbers;
};

// Owns the numbers that its patch names.
struct CheckedPatch {
  std::vector<float> numbers;
  double extent = 0;
  int degree_u = 0, degree_v = 0;
  bool is_rational = false;

  Patch patch() const {
    return {numbers.data(), extent, static_cast<uint8_t>(degree_u), static_cast<uint8_t>(degree_v),
            is_rational};
  }
};

// Returns: the patch, or what is wrong with it: a degree of 0 or above kPatchDegreeMax, another
// count of numbers than the degrees ask for, NaN, infinities, a weight not above 0, or all points
// in one place. A patch that is a line or has collapsed borders is none of these: rays in general
// miss the one, and meet the other.
Result<CheckedPatch> checked_patch(const PatchInput& input);

}  // namespace tessera::core
