// SPDX-License-Identifier: Apache-2.0
// Functions of real numbers, under the names that code uses which is compiled for plain numbers and
// for registers (common/math/vec3_text.h, slave/core/simd/real-inl.h). Each does what processors do
// with one lane, to the bit: min and max give b where the comparison does not hold, hence for NaN.
// Threads. Pure functions.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

namespace tessera {

template <class T>
concept Signed = std::floating_point<T> || std::same_as<T, std::int32_t>;

template <Signed T>
constexpr T min(T a, std::type_identity_t<T> b) {
  return a < b ? a : b;
}
template <Signed T>
constexpr T max(T a, std::type_identity_t<T> b) {
  return a > b ? a : b;
}
template <std::floating_point T>
inline T abs(T a) {
  return std::fabs(a);
}
template <std::floating_point T>
inline T sqrt(T a) {
  return std::sqrt(a);
}
// a where the mask holds, else b.
template <Signed T>
constexpr T select(bool mask, T a, std::type_identity_t<T> b) {
  return mask ? a : b;
}

}  // namespace tessera
