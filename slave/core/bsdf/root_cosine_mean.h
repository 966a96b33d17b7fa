// SPDX-License-Identifier: Apache-2.0
// Means of tables over all directions.
// Threads. Pure functions.
#pragma once

#include <cstddef>

namespace tessera::core {

// Twice the integral over the cosine of a function times the cosine. The function is linear between
// its nodes, which are spaced evenly in t, the root of the cosine, so this is the integral of
// 4 t^3 (a + b t). get: the value at a node.
template <class Get>
float mean_by_root_cosine(std::size_t nodes, Get get) {
  double sum = 0;
  const auto last = static_cast<double>(nodes - 1);
  for (std::size_t i = 0; i + 1 < nodes; ++i) {
    const double t0 = static_cast<double>(i) / last, t1 = static_cast<double>(i + 1) / last;
    const double b = (get(i + 1) - get(i)) * last, a = get(i) - b * t0;
    const double fourth0 = t0 * t0 * t0 * t0, fourth1 = t1 * t1 * t1 * t1;
    sum += a * (fourth1 - fourth0) + b * 0.8 * (fourth1 * t1 - fourth0 * t0);
  }
  return static_cast<float>(sum);
}

}  // namespace tessera::core
