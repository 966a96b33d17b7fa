// SPDX-License-Identifier: Apache-2.0
// Lane code that reads as arithmetic, and texts that stand once for plain numbers and for
// registers.
//
// Operators of registers are Highway's; here is what it lacks: a number beside a register, which
// stands for all lanes (`1 - z * z`), `-v`, and `&&`, `||` and `!` of masks. The functions are
// those that common/math/real.h and simd/plain.h have of plain numbers, by the same names.
//
// A text is an -inl.h file between TESSERA_BEFORE_TEXT() and TESSERA_AFTER_TEXT(), in namespace
// TESSERA_TEXT of tessera::core. It names the number T alone: float, or Floats. Kernels compile it
// once per instruction set, in Highway's namespace of the set and with its attributes. A header for
// plain code defines TESSERA_PLAIN_TEXT and includes it, which gives the namespace `plain` and no
// attributes: so no inline function is compiled for two processors under one name, and one that an
// AVX-512 kernel has made is never called elsewhere.
//
// Threads. Pure functions.
#include <stddef.h>
#include <stdint.h>

#if defined(TESSERA_CORE_REAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_REAL_INL_H_
#undef TESSERA_CORE_REAL_INL_H_
#else
#define TESSERA_CORE_REAL_INL_H_
#endif

#ifdef TESSERA_PLAIN_TEXT

#include "slave/core/simd/plain.h"

#define TESSERA_TEXT plain
#define TESSERA_BEFORE_TEXT() static_assert(true)
#define TESSERA_AFTER_TEXT() static_assert(true)
#define TESSERA_INLINE inline

#else

#include "slave/core/simd/lanes-inl.h"

#define TESSERA_TEXT HWY_NAMESPACE
#define TESSERA_BEFORE_TEXT() HWY_BEFORE_NAMESPACE()
#define TESSERA_AFTER_TEXT() HWY_AFTER_NAMESPACE()
#define TESSERA_INLINE HWY_INLINE

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Registers that the kernels work with: as many lanes as the set has, up to 16.
using Floats = hn::Vec<hn::CappedTag<float, 16> >;
using Ints = hn::Vec<hn::CappedTag<int32_t, 16> >;
using Uints = hn::Vec<hn::CappedTag<uint32_t, 16> >;
template <size_t kMost>
using FloatsOf = hn::Vec<hn::CappedTag<float, kMost> >;
// A register of doubles has as many lanes as the set allows; one or two of them hold the lanes of a
// register of floats.
using Doubles = hn::Vec<hn::CappedTag<double, hn::MaxLanes(hn::CappedTag<float, 16>())> >;

// Types that belong to a register V: its tag, a lane, its mask, registers of other numbers with as
// many lanes.
template <class V>
using TagOf = hn::DFromV<V>;
template <class V>
using LaneOf = hn::TFromV<V>;
template <class V>
using MaskOf = hn::Mask<TagOf<V> >;
template <class V>
using FloatOf = hn::Vec<hn::Rebind<float, TagOf<V> > >;
template <class V>
using IntOf = hn::Vec<hn::Rebind<int32_t, TagOf<V> > >;
template <class V>
using UintOf = hn::Vec<hn::Rebind<uint32_t, TagOf<V> > >;
template <class V>
constexpr size_t kLanesOf = hn::MaxLanes(TagOf<V>());
constexpr size_t kLaneCount = kLanesOf<Floats>;

template <class V>
concept Register = requires {
  typename V::PrivateT;
};
template <class M>
concept RegisterMask = requires(M mask) {
  hn::ExclusiveNeither(mask, mask);
};

// A register all of whose lanes are a.
template <Register V>
HWY_INLINE V set(LaneOf<V> a) {
  return hn::Set(TagOf<V>(), a);
}

#define TESSERA_BESIDE_NUMBERS(op)                \
  template <Register V>                           \
  HWY_INLINE auto operator op(V a, LaneOf<V> b) { \
    return a op set<V>(b);                        \
  }
#define TESSERA_BOTH_SIDES(op)                    \
  TESSERA_BESIDE_NUMBERS(op)                      \
  template <Register V>                           \
  HWY_INLINE auto operator op(LaneOf<V> a, V b) { \
    return set<V>(a) op b;                        \
  }
TESSERA_BOTH_SIDES(+)
TESSERA_BOTH_SIDES(-)
TESSERA_BOTH_SIDES(*)
TESSERA_BOTH_SIDES(/)
TESSERA_BESIDE_NUMBERS(&)
TESSERA_BESIDE_NUMBERS(|)
TESSERA_BESIDE_NUMBERS(^)
TESSERA_BESIDE_NUMBERS(<)
TESSERA_BESIDE_NUMBERS(<=)
TESSERA_BESIDE_NUMBERS(>)
TESSERA_BESIDE_NUMBERS(>=)
TESSERA_BESIDE_NUMBERS(==)
TESSERA_BESIDE_NUMBERS(!=)
#undef TESSERA_BOTH_SIDES
#undef TESSERA_BESIDE_NUMBERS

template <Register V>
HWY_INLINE V operator-(V a) {
  return hn::Neg(a);
}

// Both sides are evaluated, as ever with lanes.
template <RegisterMask M>
HWY_INLINE M operator&&(M a, M b) {
  return hn::And(a, b);
}
template <RegisterMask M>
HWY_INLINE M operator||(M a, M b) {
  return hn::Or(a, b);
}
template <RegisterMask M>
HWY_INLINE M operator!(M a) {
  return hn::Not(a);
}

// `!a && b` at once.
template <RegisterMask M>
HWY_INLINE M and_not(M a, M b) {
  return hn::AndNot(a, b);
}

// On the scalar target Highway's Min and Max return the operand that is not NaN, but processors
// return the second; min() and max() do as processors do.
template <Register V>
HWY_INLINE V min(V a, V b) {
#if HWY_TARGET == HWY_SCALAR
  return a.raw < b.raw ? a : b;
#else
  return hn::Min(a, b);
#endif
}
template <Register V>
HWY_INLINE V min(V a, LaneOf<V> b) {
  return min(a, set<V>(b));
}
template <Register V>
HWY_INLINE V max(V a, V b) {
#if HWY_TARGET == HWY_SCALAR
  return a.raw > b.raw ? a : b;
#else
  return hn::Max(a, b);
#endif
}
template <Register V>
HWY_INLINE V max(V a, LaneOf<V> b) {
  return max(a, set<V>(b));
}
template <Register V>
HWY_INLINE V abs(V a) {
  return hn::Abs(a);
}
// abs() and max() by the names that plain numbers have in kernels, for texts of plain numbers and
// registers alike.
template <Register V>
HWY_INLINE V abs_of(V a) {
  return abs(a);
}
template <Register V>
HWY_INLINE V max_of(V a, V b) {
  return max(a, b);
}

template <Register V>
HWY_INLINE V sqrt(V a) {
  return hn::Sqrt(a);
}
template <Register V>
HWY_INLINE V floor(V a) {
  return hn::Floor(a);
}
template <Register V>
HWY_INLINE V copy_sign(V size, V sign) {
  return hn::CopySign(size, sign);
}

// The mask of lanes of another kind of number, as one of V's.
template <Register V, RegisterMask M>
HWY_INLINE MaskOf<V> mask_as(M mask) {
  return hn::RebindMask(TagOf<V>(), mask);
}
// a where the mask holds, else b, or zero.
template <RegisterMask M, Register V>
HWY_INLINE V select(M mask, V a, V b) {
  return hn::IfThenElse(mask_as<V>(mask), a, b);
}
template <RegisterMask M, Register V>
HWY_INLINE V zero_unless(M mask, V a) {
  return hn::IfThenElseZero(mask_as<V>(mask), a);
}
template <RegisterMask M, Register V>
HWY_INLINE V zero_if(M mask, V a) {
  return hn::IfThenZeroElse(mask_as<V>(mask), a);
}
template <Register V>
HWY_INLINE bool is_all(MaskOf<V> mask) {
  return hn::AllTrue(TagOf<V>(), mask);
}
template <Register V>
HWY_INLINE bool is_none(MaskOf<V> mask) {
  return hn::AllFalse(TagOf<V>(), mask);
}
template <Register V>
HWY_INLINE size_t count_of(MaskOf<V> mask) {
  return hn::CountTrue(TagOf<V>(), mask);
}
template <Register V>
HWY_INLINE uint32_t bits_of(MaskOf<V> mask) {
  return bits_of(TagOf<V>(), mask);
}
template <Register V>
HWY_INLINE MaskOf<V> mask_of(uint32_t bits) {
  return mask_of(TagOf<V>(), bits);
}
// The first `count` lanes, or all.
template <Register V>
HWY_INLINE MaskOf<V> first_lanes(size_t count) {
  return hn::FirstN(TagOf<V>(), count);
}
template <Register V>
HWY_INLINE LaneOf<V> least_lane(V a) {
  return hn::GetLane(hn::MinOfLanes(TagOf<V>(), a));
}
template <Register V>
HWY_INLINE LaneOf<V> greatest_lane(V a) {
  return hn::GetLane(hn::MaxOfLanes(TagOf<V>(), a));
}

// Addresses are aligned, except for functions whose names say otherwise.
template <Register V>
HWY_INLINE V load(const LaneOf<V>* from) {
  return hn::Load(TagOf<V>(), from);
}
template <Register V>
HWY_INLINE V load_unaligned(const LaneOf<V>* from) {
  return hn::LoadU(TagOf<V>(), from);
}
template <Register V>
HWY_INLINE void store(V a, LaneOf<V>* to) {
  hn::Store(a, TagOf<V>(), to);
}
template <Register V>
HWY_INLINE void store_unaligned(V a, LaneOf<V>* to) {
  hn::StoreU(a, TagOf<V>(), to);
}
// Stores the lanes of the mask; the others stay as they are. The whole register is stored, so that
// what loads it next need not wait, as it has to after a store by mask.
template <Register V, RegisterMask M>
HWY_INLINE void store_where(M mask, V a, LaneOf<V>* to) {
  store(select(mask, a, load<V>(to)), to);
}
// Stores the lanes of the mask side by side; up to a whole register is written.
template <Register V, RegisterMask M>
HWY_INLINE void store_packed(V a, M mask, LaneOf<V>* to) {
  store_packed(TagOf<V>(), a, mask_as<V>(mask), to);
}
// first, first + 1, ...
template <Register V>
HWY_INLINE V counting_from(LaneOf<V> first) {
  return hn::Iota(TagOf<V>(), first);
}
template <class Lane, Register VI>
HWY_INLINE auto gather(const Lane* table, VI number) {
  return hn::GatherIndex(hn::Rebind<Lane, TagOf<VI> >(), table, number);
}

// a * b + c and others with one rounding where the set has it, and two elsewhere: for bounds alone,
// whose bits nobody sees.
template <Register V>
HWY_INLINE V mul_add(V a, V b, V c) {
  return hn::MulAdd(a, b, c);
}
template <Register V>
HWY_INLINE V mul_sub(V a, V b, V c) {
  return hn::MulSub(a, b, c);
}
// c - a * b.
template <Register V>
HWY_INLINE V neg_mul_add(V a, V b, V c) {
  return hn::NegMulAdd(a, b, c);
}

// Converts to numbers of the same size, of twice that and of half.
template <Register To, Register From>
HWY_INLINE To convert(From a) {
  if constexpr (sizeof(LaneOf<To>) > sizeof(LaneOf<From>)) return hn::PromoteTo(TagOf<To>(), a);
  if constexpr (sizeof(LaneOf<To>) < sizeof(LaneOf<From>)) return hn::DemoteTo(TagOf<To>(), a);
  if constexpr (sizeof(LaneOf<To>) == sizeof(LaneOf<From>)) return hn::ConvertTo(TagOf<To>(), a);
}
template <Register To, Register From>
HWY_INLINE To bit_cast(From a) {
  return hn::BitCast(TagOf<To>(), a);
}

// Loads as many numbers as a register of doubles has lanes.
template <class Lane>
HWY_INLINE Doubles in_double(const Lane* from) {
  return convert<Doubles>(load<hn::Vec<hn::Rebind<Lane, TagOf<Doubles> > > >(from));
}

// As inverse_power() of a plain number (lanes-inl.h).
template <Register V>
HWY_INLINE V inverse_power(V value) {
  using VU = hn::Vec<hn::Rebind<uint64_t, TagOf<V> > >;
  const VU exponent = bit_cast<VU>(value) & (uint64_t{0x7ff} << 52);
  return bit_cast<V>(set<VU>(uint64_t{0x7fe} << 52) - exponent);
}

template <int kBits, Register V>
HWY_INLINE V shift_left(V a) {
  return hn::ShiftLeft<kBits>(a);
}
template <int kBits, Register V>
HWY_INLINE V shift_right(V a) {
  return hn::ShiftRight<kBits>(a);
}
template <Register VI>
HWY_INLINE MaskOf<VI> has_bit(VI a, LaneOf<VI> bit) {
  return hn::TestBit(a, set<VI>(bit));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
