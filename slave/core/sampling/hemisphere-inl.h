// SPDX-License-Identifier: Apache-2.0
// The directions of sampling/hemisphere.h in lanes, to the bit.
// Threads. Pure functions.
#if defined(TESSERA_CORE_HEMISPHERE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_HEMISPHERE_INL_H_
#undef TESSERA_CORE_HEMISPHERE_INL_H_
#else
#define TESSERA_CORE_HEMISPHERE_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class V>
struct SinCos {
  V sin, cos;
};

// sin and cos of 2 pi x, x in [-1/8, 1/8].
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE SinCos<V> sin_cos_turn(Tag d, V x) {
  const V one = hn::Set(d, 1), a = hn::Mul(hn::Set(d, 6.28318531f), x), b = hn::Mul(a, a);
  const auto next = [&](float c, V sum) { return hn::Add(hn::Set(d, c), hn::Mul(b, sum)); };
  const V sin = next(-1 / 6.0f, next(1 / 120.0f, next(-1 / 5040.0f, hn::Set(d, 1 / 362880.0f))));
  const V cos = next(-0.5f, next(1 / 24.0f, next(-1 / 720.0f, hn::Set(d, 1 / 40320.0f))));
  return {hn::Mul(a, hn::Add(one, hn::Mul(b, sin))), hn::Add(one, hn::Mul(b, cos))};
}

// The same for x in [0, 1].
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE SinCos<V> sin_cos_whole_turn(Tag d, V x) {
  const hn::RebindToSigned<Tag> di;
  const auto quarter =
      hn::ConvertTo(di, hn::Add(hn::Mul(hn::Set(d, 4), x), hn::Set(d, 0.5f)));  // the nearest
  const V rest = hn::Sub(x, hn::Mul(hn::Set(d, 0.25f), hn::ConvertTo(d, quarter)));
  const SinCos<V> t = sin_cos_turn(d, rest);
  const auto has_bit = [&](auto number, int32_t bit) {
    return hn::RebindMask(d, hn::TestBit(number, hn::Set(di, bit)));
  };
  const auto is_odd = has_bit(quarter, 1);
  const V sin = hn::IfThenElse(is_odd, t.cos, t.sin), cos = hn::IfThenElse(is_odd, t.sin, t.cos);
  const auto next = hn::Add(quarter, hn::Set(di, 1));
  return {hn::IfThenElse(has_bit(quarter, 2), hn::Neg(sin), sin),
          hn::IfThenElse(has_bit(next, 2), hn::Neg(cos), cos)};
}

// Two unit vectors that are perpendicular to a unit vector and to each other.
template <class Tag>
struct Basis {
  Vec3<Tag> tangent, bitangent;
};
template <class Tag>
HWY_INLINE Basis<Tag> basis_about(Tag d, Vec3<Tag> n) {
  const auto one = hn::Set(d, 1), sign = hn::CopySign(one, n.z);
  const auto a = hn::Div(hn::Set(d, -1), hn::Add(sign, n.z));
  const auto b = hn::Mul(hn::Mul(n.x, n.y), a);
  const auto signed_x = hn::Mul(sign, n.x);
  return {{hn::Add(one, hn::Mul(hn::Mul(signed_x, n.x), a)), hn::Mul(sign, b), hn::Neg(signed_x)},
          {b, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), a)), hn::Neg(n.y)}};
}

// Of pdf cosine / pi about `normal`. x, y: in the unit square, which is mapped onto the disk.
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE Vec3<Tag> cosine_direction(Tag d, Vec3<Tag> normal, V x, V y) {
  const V one = hn::Set(d, 1), zero = hn::Zero(d);
  const V a = hn::Sub(hn::Add(x, x), one), b = hn::Sub(hn::Add(y, y), one);
  const auto is_wide = hn::Gt(hn::Abs(a), hn::Abs(b));
  const V longer = hn::IfThenElse(is_wide, a, b), shorter = hn::IfThenElse(is_wide, b, a);
  const auto is_middle = hn::Eq(longer, zero);
  const SinCos<V> t = sin_cos_turn(d, hn::Mul(hn::Div(shorter, longer), hn::Set(d, 0.125f)));
  const V along = hn::IfThenZeroElse(is_middle, hn::Mul(longer, t.cos));
  const V across = hn::IfThenZeroElse(is_middle, hn::Mul(longer, t.sin));
  const V disk_x = hn::IfThenElse(is_wide, along, across);
  const V disk_y = hn::IfThenElse(is_wide, across, along);
  const V rest = hn::Sub(hn::Sub(one, hn::Mul(disk_x, disk_x)), hn::Mul(disk_y, disk_y));
  const Basis<Tag> basis = basis_about(d, normal);
  return basis.tangent * disk_x + basis.bitangent * disk_y + normal * hn::Sqrt(hn::Max(zero, rest));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
