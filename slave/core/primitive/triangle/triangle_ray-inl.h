// SPDX-License-Identifier: Apache-2.0
// The test of one ray against the triangles of a block, all at once.
//
// Method. triangle_sight-inl.h says which triangles may be hit and which surely are; of those t is
// computed one by one, by plane-inl.h, and exact_hit() decides what is not sure.
//
// Where many triangles of a block are open, elsewhere-inl.h rules most of them out before the rest
// is decided.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#undef TESSERA_CORE_TRIANGLE_RAY_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_RAY_INL_H_
#endif

#include "slave/core/primitive/triangle/elsewhere-inl.h"
#include "slave/core/primitive/triangle/plane-inl.h"
#include "slave/core/primitive/triangle/triangle_sight-inl.h"
#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
class TriangleRay {
 public:
  explicit TriangleRay(OneRay& ray) : ray_(ray), sight_(ray) {}

  // Requires, before tests: the ray is set up.
  HWY_INLINE void prepare() { sight_.prepare(); }
  HWY_INLINE void test(const TriangleBlock<W>& block);
  // What test() does, in two steps. Requires: a register has room for a whole block.
  HWY_INLINE Candidates look(const TriangleBlock<W>& block) const {
    return sight_.template look<false>(block, 0, ray_.excluded);
  }
  HWY_INLINE void settle(const TriangleBlock<W>& block, const Candidates& found) {
    settle(block, 0, found);
  }
  // Tests one triangle. is_sure: whether the line surely passes through it.
  HWY_INLINE void test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure);
  bool has_hit() const { return ray_.has_hit(); }

  // Up to so many open triangles of a step are decided at once, which costs no more than
  // elsewhere().
  static constexpr int kFew = static_cast<int>(TriangleSight<W, kAny>::kStep / 4);

 private:
  using V = FloatsOf<W>;  // triangles
  static constexpr size_t kStep = kLanesOf<V>;

  HWY_INLINE void settle(const TriangleBlock<W>& block, size_t first, const Candidates& found);
  HWY_NOINLINE uint32_t elsewhere(const TriangleBlock<W>& block, size_t first) const;
  HWY_NOINLINE bool decide(const TriangleBlock<W>& block, size_t lane, bool counts, float& t) const;

  OneRay& ray_;
  TriangleSight<W, kAny> sight_;
};

template <int W, bool kAny>
void TriangleRay<W, kAny>::test(const TriangleBlock<W>& block) {
  TESSERA_COUNT(blocks, 1);
  for (size_t first = 0; first < W; first += kStep) {
    const Candidates found = sight_.template look<true>(block, first, ray_.excluded);
    settle(block, first, found);
    if (kAny && found.certain != 0) return;
  }
}

template <int W, bool kAny>
void TriangleRay<W, kAny>::settle(const TriangleBlock<W>& block, size_t first,
                                  const Candidates& found) {
  if (kAny && found.certain != 0) {
    const auto lane = first + static_cast<size_t>(__builtin_ctz(found.certain));
    return ray_.template accept<kAny>(ray_.best_t, static_cast<int32_t>(block.primitive[lane]));
  }
  uint32_t bits = found.possible;
  const uint32_t open = bits & ~found.sure;
  if (HWY_UNLIKELY(__builtin_popcount(open) > kFew)) bits &= ~(open & elsewhere(block, first));
  for (; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(bits));
    test_triangle(block, first + lane, found.sure >> lane & 1u);
  }
}

// Returns: bits of triangles, from `first` on, that the ray surely misses.
template <int W, bool kAny>
uint32_t TriangleRay<W, kAny>::elsewhere(const TriangleBlock<W>& block, size_t first) const {
  uint32_t found = 0;
  for (size_t at = 0; at < kStep; at += kLanesOf<Doubles>) {
    const auto corner = [&](size_t k) HWY_ATTR { return in_double(block.vertex[k] + first + at); };
    const auto of = [](const float* v) {
      return [v](size_t k) HWY_ATTR { return set<Doubles>(static_cast<double>(v[k])); };
    };
    const auto out = is_elsewhere(corner, of(ray_.origin), of(ray_.direction));
    found |= uint32_t{bits_of<Doubles>(out)} << at;
  }
  return found;
}

// Decides a triangle that candidates() leaves open. counts: whether t is that of the plane; else it
// is found.
template <int W, bool kAny>
bool TriangleRay<W, kAny>::decide(const TriangleBlock<W>& block, size_t lane, bool counts,
                                  float& t) const {
  TESSERA_COUNT(exact, 1);
  float triangle[9];
  for (size_t k = 0; k < 9; ++k) triangle[k] = block.vertex[k][lane];
  if (counts) return is_exact_hit(ray_.origin, ray_.direction, triangle);
  const ExactHit exact = exact_hit(ray_.origin, ray_.direction, triangle);
  t = exact.t;
  return exact.is_hit;
}

template <int W, bool kAny>
void TriangleRay<W, kAny>::test_triangle(const TriangleBlock<W>& block, size_t lane, bool is_sure) {
  TESSERA_COUNT(candidates, 1);
  const Plane plane = plane_of(block, lane, ray_.origin);
  float t = 0, speed = 0;
  const bool counts = plane_t(plane, ray_.direction, ray_.size, speed, t);
  const auto number = static_cast<int32_t>(block.primitive[lane]);
  if (counts && !ray_.is_nearer(t, number)) return;
  if (!counts || !is_sure) {
    if (!decide(block, lane, counts, t)) return;
    if (!counts && !ray_.is_nearer(t, number)) return;
  }
  ray_.template accept<kAny>(t, number);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
