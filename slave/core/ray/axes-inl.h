// SPDX-License-Identifier: Apache-2.0
// Vectors by axis, of one ray or of several side by side: each has four lanes, the fourth of which
// is nobody's. A register of 16 lanes holds those of four rays, so what prepares a ray for boxes
// costs little more for four rays than for one.
//
// Threads. Pure functions.
#include <stddef.h>
#include <stdint.h>

#if defined(TESSERA_CORE_AXES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_AXES_INL_H_
#undef TESSERA_CORE_AXES_INL_H_
#else
#define TESSERA_CORE_AXES_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// V: a register of 1 lane, or of 4, 8 or 16. Rays are told apart by functions: at(r) is where ray r
// has its vector.
template <class V>
class Axes {
  static constexpr size_t kStep = kLanesOf<V>;
  static constexpr size_t kParts = kStep < 4 ? 4 / kStep : 1;

 public:
  static constexpr size_t kRays = kStep < 4 ? 1 : kStep / 4;
  static constexpr uint32_t kAllBits = (1u << 4 * kRays) - 1;

  // Which axes of which rays, four bits of a number for each.
  struct Mask {
    MaskOf<V> part[kParts];
    HWY_INLINE uint32_t bits() const {
      uint32_t bits = 0;
      for (size_t p = 0; p < kParts; ++p) bits |= bits_of<V>(part[p]) << p * kStep;
      return bits;
    }
    HWY_INLINE bool is_all() const { return bits() == kAllBits; }
  };

  static HWY_INLINE Axes all(float number) {
    return each([&](size_t) HWY_ATTR { return set<V>(number); });
  }
  // Requires: each address is a multiple of 16 bytes, and four numbers are there.
  template <class At>
  static HWY_INLINE Axes load_each(const At& at) {
    return from<true>(at);
  }
  template <class At>
  static HWY_INLINE Axes load_unaligned_each(const At& at) {
    return from<false>(at);
  }
  template <class At>
  HWY_INLINE void store_each(const At& at) const;

  // Component k of each ray's vector, for all of its axes.
  template <int k>
  HWY_INLINE Axes component() const {
#if HWY_TARGET == HWY_SCALAR
    return each([&](size_t) HWY_ATTR { return part_[k]; });
#else
    return {{hn::Broadcast<k>(part_[0])}};
#endif
  }
  // The greatest of each ray's components, for all of its axes.
  HWY_INLINE Axes greatest() const {
#if HWY_TARGET == HWY_SCALAR
    const V most = max(max(part_[0], part_[1]), max(part_[2], part_[3]));
    return {{most, most, most, most}};
#else
    const V pairs = max(part_[0], hn::Shuffle2301(part_[0]));
    return {{max(pairs, hn::Shuffle1032(pairs))}};
#endif
  }
  // The fourth lane is 0.
  HWY_INLINE Axes without_fourth() const {
#if HWY_TARGET == HWY_SCALAR
    return {{part_[0], part_[1], part_[2], set<V>(0)}};
#else
    return {{zero_unless(mask_of<V>(0x7777), part_[0])}};
#endif
  }
  // Three numbers of one ray, and 0.
  static HWY_INLINE Axes of_three(float a, float b, float c) {
#if HWY_TARGET == HWY_SCALAR
    return {{set<V>(a), set<V>(b), set<V>(c), set<V>(0)}};
#else
    const V first = zero_unless(mask_of<V>(1), set<V>(a));
    return {{select(mask_of<V>(4), set<V>(c), select(mask_of<V>(2), set<V>(b), first))}};
#endif
  }
  // With that number in the fourth lane, of one ray.
  HWY_INLINE Axes with_fourth(float number) const {
#if HWY_TARGET == HWY_SCALAR
    return {{part_[0], part_[1], part_[2], set<V>(number)}};
#else
    return {{select(mask_of<V>(8), set<V>(number), part_[0])}};
#endif
  }
  // The vector of the fourth lanes of three.
  static HWY_INLINE Axes fourths(Axes a, Axes b, Axes c) {
#if HWY_TARGET == HWY_SCALAR
    return {{a.part_[3], b.part_[3], c.part_[3], set<V>(0)}};
#else
    const TagOf<V> d;
    const hn::Repartition<uint64_t, TagOf<V> > pairs;
    const auto ab = hn::BitCast(pairs, hn::InterleaveUpper(d, a.part_[0], b.part_[0]));
    const auto c0 = hn::BitCast(pairs, hn::InterleaveUpper(d, c.part_[0], hn::Zero(d)));
    return {{hn::BitCast(d, hn::InterleaveUpper(pairs, ab, c0))}};
#endif
  }
  // Axis k of ray r.
  HWY_INLINE float of(size_t r, size_t k) const {
#if HWY_TARGET == HWY_SCALAR
    return part_[4 * r + k].raw;
#else
    return hn::ExtractLane(part_[0], 4 * r + k);
#endif
  }

  HWY_INLINE Axes larger(Axes b) const {
    return both(b, [](V x, V y) HWY_ATTR { return max(x, y); });
  }
  HWY_INLINE Axes size() const {
    return each([&](size_t p) HWY_ATTR { return abs(part_[p]); });
  }
  // The size of this one with the sign of b.
  HWY_INLINE Axes with_sign(Axes b) const {
    return both(b, [](V x, V y) HWY_ATTR { return copy_sign(x, y); });
  }
  // this * b + c, for bounds.
  HWY_INLINE Axes mul_add(Axes b, Axes c) const {
    return each([&](size_t p)
                    HWY_ATTR { return HWY_NAMESPACE::mul_add(part_[p], b.part_[p], c.part_[p]); });
  }
  // This one where the mask holds, else b.
  HWY_INLINE Axes where(const Mask& mask, Axes b) const {
    return each([&](size_t p) HWY_ATTR { return select(mask.part[p], part_[p], b.part_[p]); });
  }
  HWY_INLINE Axes or_zero(const Mask& mask) const {
    return each([&](size_t p) HWY_ATTR { return zero_unless(mask.part[p], part_[p]); });
  }

  friend HWY_INLINE Axes operator+(Axes a, Axes b) {
    return a.both(b, [](V x, V y) HWY_ATTR { return x + y; });
  }
  friend HWY_INLINE Axes operator-(Axes a, Axes b) {
    return a.both(b, [](V x, V y) HWY_ATTR { return x - y; });
  }
  friend HWY_INLINE Axes operator*(Axes a, Axes b) {
    return a.both(b, [](V x, V y) HWY_ATTR { return x * y; });
  }
  friend HWY_INLINE Axes operator/(Axes a, Axes b) {
    return a.both(b, [](V x, V y) HWY_ATTR { return x / y; });
  }
  friend HWY_INLINE Axes operator-(Axes a) {
    return a.each([&](size_t p) HWY_ATTR { return -a.part_[p]; });
  }
  friend HWY_INLINE Mask operator<(Axes a, Axes b) {
    return a.compared(b, [](V x, V y) HWY_ATTR { return x < y; });
  }
  friend HWY_INLINE Mask operator<=(Axes a, Axes b) {
    return a.compared(b, [](V x, V y) HWY_ATTR { return x <= y; });
  }
  friend HWY_INLINE Mask operator==(Axes a, Axes b) {
    return a.compared(b, [](V x, V y) HWY_ATTR { return x == y; });
  }

  V part_[kParts];

 private:
  template <class Part>
  static HWY_INLINE Axes each(const Part& part) {
    if constexpr (kParts == 1) return {{part(0)}};
    Axes result;
    for (size_t p = 0; p < kParts; ++p) result.part_[p] = part(p);
    return result;
  }
  template <class Op>
  HWY_INLINE Axes both(Axes b, const Op& op) const {
    return each([&](size_t p) HWY_ATTR { return op(part_[p], b.part_[p]); });
  }
  template <class Op>
  HWY_INLINE Mask compared(Axes b, const Op& op) const {
    Mask mask;
    for (size_t p = 0; p < kParts; ++p) mask.part[p] = op(part_[p], b.part_[p]);
    return mask;
  }
  template <bool kIsAligned, class At>
  static HWY_INLINE Axes from(const At& at);
};

template <class V>
template <bool kIsAligned, class At>
Axes<V> Axes<V>::from(const At& at) {
#if HWY_TARGET == HWY_SCALAR
  return each([&](size_t p) HWY_ATTR { return set<V>(at(0)[p]); });
#else
  using Q = FloatsOf<4>;
  const auto quad = [&](size_t r)
                        HWY_ATTR { return kIsAligned ? load<Q>(at(r)) : load_unaligned<Q>(at(r)); };
  if constexpr (kStep == 4) {
    return {{quad(0)}};
  } else {
    using H = FloatsOf<8>;
    const auto half = [&](size_t r)
                          HWY_ATTR { return hn::Combine(TagOf<H>(), quad(r + 1), quad(r)); };
    if constexpr (kStep == 8) {
      return {{half(0)}};
    } else {
      return {{hn::Combine(TagOf<V>(), half(2), half(0))}};
    }
  }
#endif
}

template <class V>
template <class At>
void Axes<V>::store_each(const At& at) const {
#if HWY_TARGET == HWY_SCALAR
  for (size_t p = 0; p < 4; ++p) at(0)[p] = part_[p].raw;
#else
  using Q = FloatsOf<4>;
  const auto quads = [&](auto half, size_t r) HWY_ATTR {
    store(hn::LowerHalf(TagOf<Q>(), half), at(r));
    store(hn::UpperHalf(TagOf<Q>(), half), at(r + 1));
  };
  if constexpr (kStep == 4) {
    store(part_[0], at(0));
  } else if constexpr (kStep == 8) {
    quads(part_[0], 0);
  } else {
    using H = FloatsOf<8>;
    quads(hn::LowerHalf(TagOf<H>(), part_[0]), 0);
    quads(hn::UpperHalf(TagOf<H>(), part_[0]), 2);
  }
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
