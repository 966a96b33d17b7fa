// Angles in lanes, to the bit of sampling/hemisphere.h and light/sky_map.cpp: polynomials, the same on
// every processor.
// Threads. Pure functions.
#if defined(TESSERA_CORE_TURN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TURN_INL_H_
#undef TESSERA_CORE_TURN_INL_H_
#else
#define TESSERA_CORE_TURN_INL_H_
#endif

#include "slave/core/kernel/lanes-inl.h"

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

// Of x in [0, 1].
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE V arc_tangent(Tag d, V x) {
  const V b = hn::Mul(x, x);
  V sum = hn::Set(d, 0.0028662257f);
  for (const float c : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                        -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.0f}) {
    sum = hn::Add(hn::Mul(sum, b), hn::Set(d, c));
  }
  return hn::Mul(x, sum);
}

// The angle of (x, y) from the x axis, y >= 0: in [0, pi]. 0 for (0, 0).
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE V half_angle_of(Tag d, V x, V y) {
  constexpr float kPi = 3.14159274f;
  const V zero = hn::Zero(d), ax = hn::Abs(x);
  const auto is_flat = hn::Le(y, ax);
  const V tangent =
      arc_tangent(d, hn::Div(hn::IfThenElse(is_flat, y, ax), hn::IfThenElse(is_flat, ax, y)));
  const V a = hn::IfThenElse(is_flat, tangent, hn::Sub(hn::Set(d, kPi / 2), tangent));
  const V angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(hn::Set(d, kPi), a), a);
  return hn::IfThenZeroElse(hn::And(hn::Eq(ax, zero), hn::Eq(y, zero)), angle);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
