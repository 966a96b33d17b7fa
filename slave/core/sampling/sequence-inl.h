// SPDX-License-Identifier: Apache-2.0
// The hashes and samples of sampling/sample_sequence.h in lanes, to the bit.
// Threads. Pure functions.
#include <stdint.h>

#include "slave/core/sampling/sample_layout.h"

#if defined(TESSERA_CORE_SEQUENCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SEQUENCE_INL_H_
#undef TESSERA_CORE_SEQUENCE_INL_H_
#else
#define TESSERA_CORE_SEQUENCE_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int kBits>
struct Shift {
  static constexpr int value = kBits;
};

// du: tag of uint32_t.
template <class DU, class V>
HWY_INLINE V mix_bits(DU du, V h) {
  h = hn::Xor(h, hn::ShiftRight<16>(h));
  h = hn::Mul(h, hn::Set(du, 0x85ebca6bu));
  h = hn::Xor(h, hn::ShiftRight<13>(h));
  h = hn::Mul(h, hn::Set(du, 0xc2b2ae35u));
  return hn::Xor(h, hn::ShiftRight<16>(h));
}

template <class DU, class V>
HWY_INLINE V hash_combine(DU du, V h, V value) {
  const V spread = hn::Add(hn::ShiftLeft<6>(h), hn::ShiftRight<2>(h));
  return mix_bits(du, hn::Xor(h, hn::Add(hn::Add(value, hn::Set(du, 0x9e3779b9u)), spread)));
}

// In [0, 1).
template <class DU, class V>
HWY_INLINE auto unit_float(DU du, V bits) {
  const hn::RebindToSigned<DU> di;
  const hn::RebindToFloat<DU> d;
  static_cast<void>(du);
  const auto whole = hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<8>(bits)));
  return hn::Mul(whole, hn::Set(d, 1.0f / 16777216.0f));
}

template <class DU, class V>
HWY_INLINE V van_der_corput_bits(DU du, V i) {
  const auto swapped = [&](V v, auto shift, uint32_t low) {
    const V mask = hn::Set(du, low);
    return hn::Or(hn::ShiftLeft<decltype(shift)::value>(hn::And(v, mask)),
                  hn::And(hn::ShiftRight<decltype(shift)::value>(v), mask));
  };
  i = swapped(i, Shift<16>(), 0x0000ffffu);
  i = swapped(i, Shift<8>(), 0x00ff00ffu);
  i = swapped(i, Shift<4>(), 0x0f0f0f0fu);
  i = swapped(i, Shift<2>(), 0x33333333u);
  return swapped(i, Shift<1>(), 0x55555555u);
}

template <class DU, class V>
HWY_INLINE V sobol2_bits(DU du, V i) {
  const auto summed = [&](V v, auto shift, uint32_t low) {
    return hn::Xor(v, hn::And(hn::ShiftRight<decltype(shift)::value>(v), hn::Set(du, low)));
  };
  i = summed(i, Shift<1>(), 0x55555555u);
  i = summed(i, Shift<2>(), 0x33333333u);
  i = summed(i, Shift<4>(), 0x0f0f0f0fu);
  i = summed(i, Shift<8>(), 0x00ff00ffu);
  return van_der_corput_bits(du, summed(i, Shift<16>(), 0x0000ffffu));
}

// Of the index, which is the same for all.
template <class DU, class V>
HWY_INLINE V shuffled_index(DU du, uint32_t index, V key) {
  const auto turned = [&](V x, uint32_t factor) {
    return hn::Xor(x, hn::Mul(x, hn::Set(du, factor)));
  };
  V x = hn::Add(van_der_corput_bits(du, hn::Set(du, index)), key);
  x = turned(turned(x, 0x6c50b47cu), 0xb82f1e52u);
  x = turned(turned(x, 0xc7afe638u), 0x8d22f6e6u);
  return van_der_corput_bits(du, x);
}

// shuffled_2d() of hash_combine(key, dimension).
inline void sample_points(uint32_t dimension, uint32_t index, SamplePoints& p) {
  const hn::CappedTag<uint32_t, 16> du;
  const hn::RebindToFloat<decltype(du)> d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(du))) {
    const auto key = hash_combine(du, hn::Load(du, p.key + i), hn::Set(du, dimension));
    const auto order = hash_combine(du, key, hn::Set(du, 0x68bc21ebu));
    const auto number = shuffled_index(du, index, order);
    const auto x = hn::Xor(van_der_corput_bits(du, number), key);
    const auto y = hn::Xor(sobol2_bits(du, number), mix_bits(du, key));
    hn::Store(unit_float(du, x), d, p.square[0] + i);
    hn::Store(unit_float(du, y), d, p.square[1] + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
