// SPDX-License-Identifier: Apache-2.0
// What simd/real-inl.h gives to a text that is compiled for plain numbers: the same names, one
// number to a register. Each function does what one lane does, to the bit.
// Threads. Pure functions.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "common/math/real.h"
#include "common/math/rounding.h"
#include "common/math/vec3.h"

namespace tessera::core::plain {

template <class T>
concept Number =
    std::floating_point<T> || std::same_as<T, std::int32_t> || std::same_as<T, std::uint32_t>;

template <class T>
struct NumbersBeside;
template <>
struct NumbersBeside<float> {
  using Int = std::int32_t;
  using Uint = std::uint32_t;
};
template <>
struct NumbersBeside<double> {
  using Float = float;
};
template <>
struct NumbersBeside<std::uint32_t> {
  using Float = float;
  using Int = std::int32_t;
};
template <>
struct NumbersBeside<std::int32_t> {
  using Float = float;
  using Uint = std::uint32_t;
};
template <class T>
using FloatOf = typename NumbersBeside<T>::Float;
template <class T>
using IntOf = typename NumbersBeside<T>::Int;
template <class T>
using UintOf = typename NumbersBeside<T>::Uint;
template <class T>
using LaneOf = T;
template <class T>
using MaskOf = bool;
template <class T>
inline constexpr std::size_t kLanesOf = 1;

inline constexpr float kRoundoff = kUnitRoundoff;
inline constexpr float kInvPi = 0.318309886f;

using tessera::abs;
using tessera::max;
using tessera::min;
using tessera::select;
using tessera::sqrt;

inline float floor(float a) { return std::floor(a); }
inline float copy_sign(float size, float sign) { return std::copysign(size, sign); }
template <Number T>
constexpr T zero_unless(bool mask, T a) {
  return mask ? a : T{0};
}
template <Number T>
constexpr T zero_if(bool mask, T a) {
  return mask ? T{0} : a;
}

template <Number T>
constexpr bool is_none(bool mask) {
  return !mask;
}
template <Number T>
constexpr T set(T a) {
  return a;
}
template <Number T>
constexpr T load(const T* from) {
  return *from;
}
template <Number T>
constexpr void store(T a, T* to) {
  *to = a;
}
template <Number T, std::size_t kCount>
constexpr Vec3<T> load3(const T (&from)[3][kCount], std::size_t at) {
  return {from[0][at], from[1][at], from[2][at]};
}
template <Number T>
constexpr T gather(const T* table, std::int32_t number) {
  return table[number];
}

template <Number To, Number From>
constexpr To convert(From a) {
  return static_cast<To>(a);
}
template <Number To, Number From>
constexpr To bit_cast(From a) {
  return std::bit_cast<To>(a);
}

template <int kBits, Number T>
constexpr T shift_left(T a) {
  return static_cast<T>(a << kBits);
}
template <int kBits, Number T>
constexpr T shift_right(T a) {
  return static_cast<T>(a >> kBits);
}
constexpr bool has_bit(std::int32_t a, std::int32_t bit) { return (a & bit) != 0; }

}  // namespace tessera::core::plain
