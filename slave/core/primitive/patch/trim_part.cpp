// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_part.h"

namespace tessera::core {

TrimPart first_half(TrimPart& part, int degree) {
  TrimPart half;
  half.from = part.from;
  half.to = middle(part.from, part.to);
  half.depth = ++part.depth;
  for (int k = 0; k <= degree; ++k) {
    half.net[k] = part.net[0];
    for (int i = 0; i < degree - k; ++i) {
      TrimCoefficient &a = part.net[i], &b = part.net[i + 1];
      a = {0.5 * (a.u + b.u), 0.5 * (a.v + b.v), 0.5 * (a.w + b.w)};
    }
  }
  part.from = half.to;
  return half;
}

}  // namespace tessera::core
