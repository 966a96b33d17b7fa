// SPDX-License-Identifier: Apache-2.0
// The powers of common/math/power.h in lanes, to the bit.
// Threads. Pure functions.
#if defined(TESSERA_CORE_POWER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_POWER_INL_H_
#undef TESSERA_CORE_POWER_INL_H_
#else
#define TESSERA_CORE_POWER_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE V log2_of(Tag d, V x) {
  const hn::RebindToSigned<Tag> di;
  const V one = hn::Set(d, 1);
  const auto bits = hn::BitCast(di, hn::Max(x, hn::Set(d, 1.17549435e-38f)));
  const auto half_root = hn::BitCast(di, hn::Set(d, 0.707106781f));
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, half_root));
  const V m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const V t = hn::Div(hn::Sub(m, one), hn::Add(m, one)), t2 = hn::Mul(t, t);
  const auto next = [&](float c, V sum) { return hn::Add(hn::Set(d, c), hn::Mul(t2, sum)); };
  const V series = next(1, next(1 / 3.0f, next(1 / 5.0f, next(1 / 7.0f, hn::Set(d, 1 / 9.0f)))));
  return hn::Add(hn::ConvertTo(d, exponent), hn::Mul(hn::Mul(hn::Set(d, 2.88539008f), t), series));
}

template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE V exp2_of(Tag d, V x) {
  const hn::RebindToSigned<Tag> di;
  const V inside = hn::Min(hn::Max(x, hn::Set(d, -126)), hn::Set(d, 126));
  const V whole = hn::Floor(hn::Add(inside, hn::Set(d, 0.5f)));
  const V a = hn::Mul(hn::Sub(inside, whole), hn::Set(d, 0.693147181f));
  const auto next = [&](float c, V sum) { return hn::Add(hn::Set(d, c), hn::Mul(a, sum)); };
  const V series = next(
      1, next(1, next(1 / 2.0f,
                      next(1 / 6.0f, next(1 / 24.0f, next(1 / 120.0f, hn::Set(d, 1 / 720.0f)))))));
  const auto scale = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, whole), hn::Set(di, 127)));
  return hn::Mul(series, hn::BitCast(d, scale));
}

// x to the power of y, y > 0; 0 where x is not above 0.
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE V power(Tag d, V x, V y) {
  return hn::IfThenElseZero(hn::Gt(x, hn::Zero(d)), exp2_of(d, hn::Mul(y, log2_of(d, x))));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
