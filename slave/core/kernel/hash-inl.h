// The hashes of sampling/sample_sequence.h in lanes, to the bit.
// Threads. Pure functions.
#include <stdint.h>

#if defined(TESSERA_CORE_HASH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_HASH_INL_H_
#undef TESSERA_CORE_HASH_INL_H_
#else
#define TESSERA_CORE_HASH_INL_H_
#endif

#include "slave/core/kernel/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

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

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
