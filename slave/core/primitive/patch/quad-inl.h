// SPDX-License-Identifier: Apache-2.0
// Four doubles as one number, in one register where the set has such ones: a row of a net of four
// by four, or x, y, z, w of a point. Lanes do what plain doubles do, so the bits are the same on
// all sets.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_QUAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_QUAD_INL_H_
#undef TESSERA_CORE_QUAD_INL_H_
#else
#define TESSERA_CORE_QUAD_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct Quad {
  using Tag = hn::CappedTag<double, 4>;
  using V = hn::Vec<Tag>;
  static constexpr size_t kLanes = hn::MaxLanes(Tag());
  static constexpr size_t kParts = 4 / kLanes;

  V part[kParts];

  static HWY_INLINE Quad loaded(const double* from) {
    Quad q;
    for (size_t k = 0; k < kParts; ++k) q.part[k] = hn::LoadU(Tag(), from + k * kLanes);
    return q;
  }
  // Three numbers of float32, and `last`. Four are read.
  static HWY_INLINE Quad of_three(const float* from, double last) {
    const Tag d;
    Quad q;
    for (size_t k = 0; k < kParts; ++k) {
      const V v = hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, Tag>(), from + k * kLanes));
      const size_t first = k * kLanes, count = first >= 3 ? 0 : 3 - first;
      q.part[k] = hn::IfThenElse(hn::FirstN(d, count), v, hn::Set(d, last));
    }
    return q;
  }
  static HWY_INLINE Quad all(double a) {
    Quad q;
    for (size_t k = 0; k < kParts; ++k) q.part[k] = hn::Set(Tag(), a);
    return q;
  }
  HWY_INLINE void store(double* to) const {
    for (size_t k = 0; k < kParts; ++k) hn::StoreU(part[k], Tag(), to + k * kLanes);
  }
  HWY_INLINE double least() const {
    V v = part[0];
    for (size_t k = 1; k < kParts; ++k) v = min(v, part[k]);
    return least_lane(v);
  }
  HWY_INLINE double greatest() const {
    V v = part[0];
    for (size_t k = 1; k < kParts; ++k) v = max(v, part[k]);
    return greatest_lane(v);
  }
};

template <class Op>
HWY_INLINE Quad by_parts(const Quad& a, const Quad& b, const Op& op) {
  Quad q;
  for (size_t k = 0; k < Quad::kParts; ++k) q.part[k] = op(a.part[k], b.part[k]);
  return q;
}
HWY_INLINE Quad operator+(const Quad& a, const Quad& b) {
  return by_parts(a, b, [](Quad::V x, Quad::V y) HWY_ATTR { return x + y; });
}
HWY_INLINE Quad operator-(const Quad& a, const Quad& b) {
  return by_parts(a, b, [](Quad::V x, Quad::V y) HWY_ATTR { return x - y; });
}
HWY_INLINE Quad operator*(const Quad& a, const Quad& b) {
  return by_parts(a, b, [](Quad::V x, Quad::V y) HWY_ATTR { return x * y; });
}
HWY_INLINE Quad operator*(double a, const Quad& b) { return Quad::all(a) * b; }
HWY_INLINE Quad min(const Quad& a, const Quad& b) {
  return by_parts(a, b, [](Quad::V x, Quad::V y) HWY_ATTR { return min(x, y); });
}
HWY_INLINE Quad max(const Quad& a, const Quad& b) {
  return by_parts(a, b, [](Quad::V x, Quad::V y) HWY_ATTR { return max(x, y); });
}

// Rows become columns.
HWY_INLINE void transpose(const Quad (&from)[4], Quad (&to)[4]) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
  const Quad::Tag d;
  const auto a = hn::InterleaveLower(d, from[0].part[0], from[1].part[0]);
  const auto b = hn::InterleaveUpper(d, from[0].part[0], from[1].part[0]);
  const auto c = hn::InterleaveLower(d, from[2].part[0], from[3].part[0]);
  const auto e = hn::InterleaveUpper(d, from[2].part[0], from[3].part[0]);
  to[0].part[0] = hn::ConcatLowerLower(d, c, a);
  to[1].part[0] = hn::ConcatLowerLower(d, e, b);
  to[2].part[0] = hn::ConcatUpperUpper(d, c, a);
  to[3].part[0] = hn::ConcatUpperUpper(d, e, b);
#else
  double lanes[4][4], other[4][4];
  for (int i = 0; i < 4; ++i) from[i].store(lanes[i]);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) other[j][i] = lanes[i][j];
  for (int i = 0; i < 4; ++i) to[i] = Quad::loaded(other[i]);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
