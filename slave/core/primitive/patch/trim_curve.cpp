// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_curve.h"

#include <bit>

namespace tessera::core {

TrimCoefficient coefficient_of(const TrimPoint& point, int degree, int index) {
  int choices = 1;
  for (int i = 0; i < index; ++i) choices = choices * (degree - i) / (i + 1);
  // The product of two numbers of float32 is exact, and the first factor has at most 13 bits.
  const double w = point.weight, many = choices;
  return {many * (w * double{point.u}), many * (w * double{point.v}), many * w};
}

TrimParameter geometric_middle(TrimParameter a, TrimParameter b) {
  const auto digits = [](TrimParameter x) { return std::bit_cast<std::uint64_t>(x.t / x.s); };
  // Neither is negative, so the order of their bits is that of the numbers; infinity is the last.
  const std::uint64_t low = digits(a), high = digits(b);
  const double ratio = std::bit_cast<double>(low / 2 + high / 2 + (low & high & 1));
  if (ratio > 1) return {1 / ratio, 1};
  return {1, ratio};
}

}  // namespace tessera::core
