// SPDX-License-Identifier: Apache-2.0
// Masks of lanes as bits of a number, for any number of lanes up to 16.
// Threads. Pure functions.
#include <stdint.h>

#if defined(TESSERA_CORE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LANES_INL_H_
#undef TESSERA_CORE_LANES_INL_H_
#else
#define TESSERA_CORE_LANES_INL_H_
#endif

#ifdef TESSERA_PLAIN_TEXT
#error "a source of kernels includes no header of plain texts (simd/real-inl.h)"
#endif

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kRoundoff = 0x1p-24f;  // u of all error bounds
constexpr float kInvPi = 0.318309886f;
// Part of every absolute tolerance: some sixteen roundings of denormal numbers, 2^-150 each, with
// room. It counts only where products of lengths come near the end of float32. It is no denormal
// number itself, since some processors take a hundred cycles for each operation with one.
constexpr float kUnderflow = 0x1p-126f;

// Cache lines that hold this many bytes from the start of one on.
constexpr size_t lines_of(size_t bytes) { return (bytes + 63) / 64; }
// Fetches cache lines ahead of their use; there need be no memory.
template <size_t kLines>
HWY_INLINE void fetch_lines(const void* from) {
  const char* const at = static_cast<const char*>(from);
  for (size_t line = 0; line < kLines; ++line) __builtin_prefetch(at + 64 * line);
}

// Bit i: lane i of the mask.
template <class Tag>
HWY_INLINE uint32_t bits_of(Tag d, hn::Mask<Tag> mask) {
#if HWY_TARGET == HWY_AVX3  // masks are numbers already, and need not pass through memory
  static_cast<void>(d);
  return mask.raw;
#else
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return static_cast<uint32_t>(bytes[0]) | static_cast<uint32_t>(bytes[1]) << 8;
#endif
}

// The mask whose lane i is set where bit i is; higher bits are ignored.
template <class Tag>
HWY_INLINE hn::Mask<Tag> mask_of(Tag d, uint32_t bits) {
#if HWY_TARGET == HWY_AVX3
  static_cast<void>(d);
  return hn::Mask<Tag>{static_cast<decltype(hn::Mask<Tag>::raw)>(bits)};
#else
  const uint8_t bytes[8] = {static_cast<uint8_t>(bits & 255u),
                            static_cast<uint8_t>(bits >> 8 & 255u)};
  return hn::LoadMaskBits(d, bytes);
#endif
}

// Stores the lanes of the mask side by side, from `to` on; up to a whole register is written there.
// Highway's packing is slow before AVX-512.
template <class Tag>
HWY_INLINE void store_packed(Tag d, hn::Vec<Tag> v, hn::Mask<Tag> mask, hn::TFromD<Tag>* to) {
#if HWY_TARGET == HWY_AVX3
  hn::StoreU(hn::Compress(v, mask), d, to);
#else
  alignas(64) hn::TFromD<Tag> lanes[hn::MaxLanes(d)];
  hn::Store(v, d, lanes);
  uint32_t bits = bits_of(d, mask);
  for (size_t lane = 0; lane < hn::MaxLanes(d); ++lane, bits >>= 1) {
    *to = lanes[lane];
    to += bits & 1u;
  }
#endif
}

// A register of float from two computations in double, each of half its lanes: part(0) the lower
// half, part(1) the upper. With one lane, part(0) alone.
template <class Tag, class Part>
HWY_INLINE hn::Vec<Tag> halves(Tag d, const Part& part) {
#if HWY_TARGET == HWY_SCALAR
  static_cast<void>(d);
  return part(0);
#else
  return hn::Combine(d, part(1), part(0));
#endif
}

HWY_INLINE float abs_of(float v) { return __builtin_fabsf(v); }
HWY_INLINE double abs_of(double v) { return __builtin_fabs(v); }
template <typename T>
HWY_INLINE T max_of(T a, T b) {
  return a > b ? a : b;
}

template <typename T>
HWY_INLINE T min_of(T a, T b) {
  return a < b ? a : b;
}

// 2^-e for a value of 2^e to 2^(e + 1); any factor near it would do.
HWY_INLINE double inverse_power(double value) {
  uint64_t bits;
  __builtin_memcpy(&bits, &value, sizeof(bits));
  bits = (uint64_t{0x7fe} << 52) - (bits & uint64_t{0x7ff} << 52);
  double result;
  __builtin_memcpy(&result, &bits, sizeof(result));
  return result;
}

// Folds the lanes of each of kRows registers by `op` (least, greatest): to[r] becomes that of
// row(r). Four registers are folded at once, lane by lane beside each other, which takes a third of
// the steps of one after the other. Requires: kRows is a multiple of 4, or there is one lane.
template <size_t kRows, class Tag, class Row, class Op>
HWY_INLINE void fold_rows(Tag d, const Row& row, const Op& op, float* HWY_RESTRICT to) {
#if HWY_TARGET == HWY_SCALAR
  static_cast<void>(d);
  static_cast<void>(op);
  for (size_t r = 0; r < kRows; ++r) to[r] = hn::GetLane(row(r));
#else
  using V = hn::Vec<Tag>;
  const hn::Repartition<uint64_t, Tag> pairs;
  // Each block of four lanes holds the folded values of four registers, in their order.
  const auto four = [&](size_t r) {
    const auto fold = [&](V a, V b) {
      return op(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
    };
    const auto ab = hn::BitCast(pairs, fold(row(r), row(r + 1)));
    const auto cd = hn::BitCast(pairs, fold(row(r + 2), row(r + 3)));
    return op(hn::BitCast(d, hn::InterleaveLower(pairs, ab, cd)),
              hn::BitCast(d, hn::InterleaveUpper(pairs, ab, cd)));
  };
  for (size_t r = 0; r < kRows; r += 4) {
    const V blocks = four(r);
    if constexpr (hn::MaxLanes(d) == 4) {
      hn::StoreU(blocks, d, to + r);
    } else {
      const hn::Half<Tag> half;
      const auto folded = op(hn::LowerHalf(half, blocks), hn::UpperHalf(half, blocks));
      if constexpr (hn::MaxLanes(d) == 8) {
        hn::StoreU(folded, half, to + r);
      } else {
        const hn::Half<hn::Half<Tag> > quarter;
        hn::StoreU(op(hn::LowerHalf(quarter, folded), hn::UpperHalf(quarter, folded)), quarter,
                   to + r);
      }
    }
  }
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
