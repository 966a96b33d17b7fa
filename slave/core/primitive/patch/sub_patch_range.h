// SPDX-License-Identifier: Apache-2.0
// Where a sub-patch lies in its patch. All numbers are exact.
// Threads. Plain values.
#pragma once

#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// u = middle_u + half_u x, v = middle_v + half_v y for x, y in [-1, 1].
struct SubPatchRange {
  double half_u, half_v, middle_u, middle_v;

  explicit SubPatchRange(const SubPatch& part)
      : half_u(1.0 / (2u << part.level_u)),
        half_v(1.0 / (2u << part.level_v)),
        middle_u((2 * part.column + 1) * half_u),
        middle_v((2 * part.row + 1) * half_v) {}
};

}  // namespace tessera::core
