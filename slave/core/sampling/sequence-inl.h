// SPDX-License-Identifier: Apache-2.0
// The hashes and digits of the sample sequence (sample_sequence.h). U: uint32_t, or Uints.
// Threads. Pure functions.
#include <stdint.h>

#include "slave/core/sampling/sample_layout.h"

#if defined(TESSERA_CORE_SEQUENCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SEQUENCE_INL_H_
#undef TESSERA_CORE_SEQUENCE_INL_H_
#else
#define TESSERA_CORE_SEQUENCE_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// A 32-bit mix with full avalanche (the finaliser of MurmurHash3; Appleby 2011).
template <class U>
TESSERA_INLINE constexpr U mix_bits(U h) {
  h = h ^ shift_right<16>(h);
  h = h * 0x85ebca6bu;
  h = h ^ shift_right<13>(h);
  h = h * 0xc2b2ae35u;
  return h ^ shift_right<16>(h);
}

template <class U>
TESSERA_INLINE constexpr U hash_combine(U h, U value) {
  return mix_bits(h ^ (value + 0x9e3779b9u + (shift_left<6>(h) + shift_right<2>(h))));
}

// Maps the 24 high bits to [0, 1): exact, never 1.
template <class U>
TESSERA_INLINE constexpr FloatOf<U> unit_float(U bits) {
  return convert<FloatOf<U>>(bit_cast<IntOf<U>>(shift_right<8>(bits))) * (1.0f / 16777216.0f);
}

// Swaps groups of kBits bits: those of the mask `low` with those above them.
template <int kBits, class U>
TESSERA_INLINE constexpr U swapped_bits(U i, uint32_t low) {
  return shift_left<kBits>(i & low) | (shift_right<kBits>(i) & low);
}

template <class U>
TESSERA_INLINE constexpr U van_der_corput_bits(U i) {
  i = swapped_bits<16>(i, 0x0000ffffu);
  i = swapped_bits<8>(i, 0x00ff00ffu);
  i = swapped_bits<4>(i, 0x0f0f0f0fu);
  i = swapped_bits<2>(i, 0x33333333u);
  return swapped_bits<1>(i, 0x55555555u);
}

// Sobol's second dimension has Pascal's triangle modulo 2 as its matrix: bit j of the index goes
// with all bits whose number holds that of j (Lucas), which five steps sum up.
template <class U>
TESSERA_INLINE constexpr U sobol2_bits(U i) {
  i = i ^ (shift_right<1>(i) & 0x55555555u);
  i = i ^ (shift_right<2>(i) & 0x33333333u);
  i = i ^ (shift_right<4>(i) & 0x0f0f0f0fu);
  i = i ^ (shift_right<8>(i) & 0x00ff00ffu);
  i = i ^ (shift_right<16>(i) & 0x0000ffffu);
  return van_der_corput_bits(i);
}

// Puts the indices into another order: aligned runs of 2^k stay together, and within them every
// order is as likely. Uses of one index in several dimensions need keys of their own; otherwise the
// dimensions are not independent, however their points are scrambled. After Burley, "Practical
// hash-based Owen scrambling", JCGT 9(4), 2020, with the hash of Laine and Karras, 2011.
template <class U>
TESSERA_INLINE constexpr U shuffled_index(uint32_t index, U key) {
  U x = van_der_corput_bits(set<U>(index)) + key;
  x = x ^ (x * 0x6c50b47cu);
  x = x ^ (x * 0xb82f1e52u);
  x = x ^ (x * 0xc7afe638u);
  x = x ^ (x * 0x8d22f6e6u);
  return van_der_corput_bits(x);
}

template <class U>
struct UnitSquare {
  FloatOf<U> x, y;  // in [0, 1)
};

// Digits of a point, scrambled by the key of its use.
template <class U>
TESSERA_INLINE constexpr UnitSquare<U> scrambled_point(U x_bits, U y_bits, U key) {
  return {unit_float(x_bits ^ key), unit_float(y_bits ^ mix_bits(key))};
}

// Point `index` of the sequence, for one of several uses of the index: see shuffled_index().
template <class U>
TESSERA_INLINE constexpr UnitSquare<U> shuffled_point(U key, uint32_t index) {
  const U number = shuffled_index(index, hash_combine(key, set<U>(0x68bc21ebu)));
  return scrambled_point(van_der_corput_bits(number), sobol2_bits(number), key);
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#ifndef TESSERA_PLAIN_TEXT

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Makes p.square: shuffled_2d(hash_combine(key, dimension), index) of each key.
inline void sample_points(uint32_t dimension, uint32_t index, SamplePoints& p) {
  for (int i = 0; i < p.count; i += static_cast<int>(kLaneCount)) {
    const Uints key = hash_combine(load<Uints>(p.key + i), set<Uints>(dimension));
    const UnitSquare<Uints> point = shuffled_point(key, index);
    store(point.x, p.square[0] + i);
    store(point.y, p.square[1] + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
