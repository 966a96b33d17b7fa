// SPDX-License-Identifier: Apache-2.0
// One ray by itself: where it goes, scaled so that nothing overflows, and what it has hit so far.
// Boxes need less of it: that part is a BoxRay, which also goes through boxes of other spaces.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_ONE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_ONE_RAY_INL_H_
#undef TESSERA_CORE_ONE_RAY_INL_H_
#else
#define TESSERA_CORE_ONE_RAY_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE float moved(float t, float share) { return t + abs_of(t) * share; }

struct BoxRay {
  using A = hn::CappedTag<float, 4>;  // axes; the fourth is 0
  static constexpr size_t kAxisStep = hn::MaxLanes(A());

  bool is_down(int axis) const { return (down >> axis & 1u) != 0; }

  alignas(16) float origin[4];
  alignas(16) float slope[4];    // the direction, scaled by a power of two where it is extreme
  alignas(16) float inverse[4];  // of the slope
  alignas(16) float pad[4];      // widening of t, where the ray hardly moves along an axis
  uint32_t down = 0;             // bits of the axes with a negative slope
  int kx = 0, ky = 1, kz = 2;    // z: the main axis
  // No integer stands next to these: compilers load pairs, and arithmetic with an integer's bits,
  // which are a denormal number, takes a hundred cycles even where the result is not used.
  float near_limit = 0, far_limit = 0;  // t_min and best_t, scaled and moved out
  float reach = 0;  // largest distance, by axis, of a point of the scene from the origin
  float scale = 1;  // scaled t = t * scale

 protected:
  // Any of the axes `is_main` (bits), along which the ray goes farthest, becomes the main one.
  HWY_INLINE void set_main_axis(uint32_t is_main) {
    kz = __builtin_ctz(is_main);
    // Shifts, since a branch on the axis is one in three that is not foreseen.
    kx = 0b00'10'01 >> 2 * kz & 3;
    ky = 0b01'00'10 >> 2 * kz & 3;
  }
  // Both take the size of the slope's largest component, which is above 0 and finite. Requires:
  // reach is set.
  // Returns: that size once the slope is scaled.
  HWY_INLINE float scale_slope(float largest);
  HWY_INLINE void invert_slope(float largest);
};

struct OneRay : BoxRay {
  // Returns: whether the ray is valid.
  HWY_INLINE bool setup(const SingleRay& ray, const SceneBox& scene);

  bool has_hit() const { return best != -1; }
  // Whether a hit at t is nearer than what the ray has, or at the same t and of a lower number.
  HWY_INLINE bool is_nearer(float t, int32_t primitive) const {
    const bool is_lower = best == -1 || primitive < best;
    return t >= t_min && (t < best_t || (t == best_t && is_lower));
  }
  template <bool kAny>
  HWY_INLINE void accept(float hit_t, int32_t primitive);

  alignas(16) float direction[4];
  float t_min = 0, best_t = 0;
  float size = 0;  // sum of |direction|
  int32_t best = -1;
  int32_t excluded[2] = {-1, -1};
};

HWY_INLINE bool OneRay::setup(const SingleRay& ray, const SceneBox& scene) {
  const A d;
  auto far = hn::Zero(d), longest = far, reached = far;
  for (size_t a = 0; a < 4; a += kAxisStep) {
    // Loads of 4 read the number behind each of the two arrays; it is a member of the ray, too.
    const auto is_axis = hn::FirstN(d, 3 - a);
    const auto from = hn::IfThenElseZero(is_axis, hn::LoadU(d, ray.origin + a));
    const auto along = hn::IfThenElseZero(is_axis, hn::LoadU(d, ray.direction + a));
    hn::Store(from, d, origin + a);
    hn::Store(along, d, direction + a);
    far = hn::Add(far, hn::Abs(from));
    longest = hn::Max(longest, hn::Abs(along));
    const auto low = hn::Abs(hn::Sub(hn::Load(d, scene.lower + a), from));
    const auto high = hn::Abs(hn::Sub(hn::Load(d, scene.upper + a), from));
    reached = hn::Max(reached, hn::Max(low, high));
  }
  const float infinity = __builtin_inff();
  size = (abs_of(direction[0]) + abs_of(direction[1])) + abs_of(direction[2]);
  if (!(size > 0 && size < infinity && ray.t_min <= ray.t_max)) return false;
  if (!hn::AllTrue(d, hn::Lt(far, hn::Inf(d)))) return false;
  const auto most = hn::MaxOfLanes(d, longest);
  const float largest = hn::GetLane(most);
  reach = hn::GetLane(hn::MaxOfLanes(d, reached));
  uint32_t is_main = 0;
  for (size_t a = 0; a < 4; a += kAxisStep)
    is_main |= bits_of(d, hn::Eq(hn::Abs(hn::Load(d, direction + a)), most)) << a;
  set_main_axis(is_main);
  for (size_t a = 0; a < 4; a += kAxisStep) hn::Store(hn::Load(d, direction + a), d, slope + a);
  invert_slope(scale_slope(largest));
  t_min = ray.t_min;
  for (int k = 0; k < 2; ++k) excluded[k] = static_cast<int32_t>(ray.excluded[k]);
  best_t = ray.t_max;
  best = -1;
  near_limit = moved(t_min * scale, -kTimeSlack);
  far_limit = moved(best_t * scale, kTimeSlack);
  return true;
}

// Scales the slope so that no product of a coordinate with an inverse overflows: the inverse is at
// most 2^60 for coordinates below 2^60 and at most 1 beyond.
HWY_INLINE float BoxRay::scale_slope(float largest) {
  const float wanted = reach < 0x1p60f ? 1.0f : 0x1p60f;
  scale = 1;
  if (HWY_LIKELY(largest > wanted * 0x1p-20f && largest < wanted * 0x1p20f)) return largest;
  while (!(largest >= wanted && largest < 2 * wanted)) {
    const float factor = largest < wanted ? 2 : 0.5f;
    for (float& s : slope) s *= factor;
    largest *= factor;
    scale /= factor;
  }
  return largest;
}

// An axis along which the ray hardly moves counts as steeper than it is. The ray leaves the scene
// within t = reach / largest (twice that with all roundings), so it moves by less than `least`
// times that along it.
HWY_INLINE void BoxRay::invert_slope(float largest) {
  const A d;
  const auto least = hn::Set(d, largest * 0x1p-40f), widest = hn::Set(d, 4 * (reach / largest));
  down = 0;
  for (size_t a = 0; a < 4; a += kAxisStep) {
    const auto own = hn::Load(d, slope + a);
    const auto is_flat = hn::Lt(hn::Abs(own), least);
    const auto used = hn::IfThenElse(is_flat, hn::CopySign(least, own), own);
    hn::Store(hn::IfThenElseZero(is_flat, widest), d, pad + a);
    hn::Store(hn::Div(hn::Set(d, 1), used), d, inverse + a);
    down |= bits_of(d, hn::Lt(used, hn::Zero(d))) << a;
  }
}

template <bool kAny>
HWY_INLINE void OneRay::accept(float hit_t, int32_t primitive) {
  best_t = kAny ? -__builtin_inff() : hit_t;
  best = primitive;
  far_limit = moved(best_t * scale, kTimeSlack);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
