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

#include "slave/core/ray/axes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE float moved(float t, float share) { return t + abs_of(t) * share; }

// Nothing is initialized before a ray is set up: many rays are set up at once, in places that are
// made anew for each packet.
struct BoxRay {
  bool is_down(int axis) const { return (down >> axis & 1u) != 0; }

  alignas(16) float origin[4];   // by axis; the fourth is 0
  alignas(16) float slope[4];    // the direction, scaled by a power of two where it is extreme
  alignas(16) float inverse[4];  // of the slope
  alignas(16) float pad[4];      // widening of t, where the ray hardly moves along an axis
  uint32_t down;                 // bits of the axes with a negative slope
  int kx, ky, kz;                // z: the main axis
  // No integer stands next to these: compilers load pairs, and arithmetic with an integer's bits,
  // which are a denormal number, takes a hundred cycles even where the result is not used.
  float near_limit, far_limit;  // t_min and best_t, scaled and moved out
  float reach;  // largest distance, by axis, of a point of the scene from the origin
  float scale;  // scaled t = t * scale

 protected:
  // Any of the axes `is_main` (bits), along which the ray goes farthest, becomes the main one.
  HWY_INLINE void set_main_axis(uint32_t is_main) {
    kz = __builtin_ctz(is_main);
    // Shifts, since a branch on the axis is one in three that is not foreseen.
    kx = 0b00'10'01 >> 2 * kz & 3;
    ky = 0b01'00'10 >> 2 * kz & 3;
  }
  // Sets what is made of the slopes of several rays. At: as for Axes; to(r) is a ray. slope: is
  // scaled where it is extreme; the largest of each is above 0 and finite. reach: of the rays.
  template <class Axes, class Ray>
  static HWY_INLINE void set_slopes(const Ray& to, Axes& slope, Axes& inverse, Axes& pad,
                                    Axes reach);

 private:
  void scale_slope();
};

struct OneRay : BoxRay {
  OneRay() {
  }  // sets nothing, see above; said so that a reference to it is no use of what is not set

  // Returns: whether the ray is valid.
  HWY_INLINE bool setup(const SingleRay& ray, const SceneBox& scene) {
    return setup_each<Axes<FloatsOf<4>>>([&](size_t) { return this; }, [&](size_t) { return &ray; },
                                         scene);
  }
  // Sets up as many rays as Axes holds, to(r) of given(r). Returns: whether all are valid; if not,
  // none is set up.
  template <class Axes, class Ray, class Given>
  static HWY_INLINE bool setup_each(const Ray& to, const Given& given, const SceneBox& scene);

  bool has_hit() const { return best != -1; }
  // Whether the ray is known not to meet the primitive (SingleRay::excluded).
  HWY_INLINE bool excludes(uint32_t primitive) const {
    const auto number = static_cast<int32_t>(primitive);
    return (excluded[0] == number) | (excluded[1] == number);
  }
  // Whether a hit at t is nearer than what the ray has, or at the same t and of a lower number.
  HWY_INLINE bool is_nearer(float t, int32_t primitive) const {
    const bool is_lower = best == -1 || primitive < best;
    return t >= t_min && (t < best_t || (t == best_t && is_lower));
  }
  template <bool kAny>
  HWY_INLINE void accept(float hit_t, int32_t primitive);

  alignas(16) float direction[4];
  float t_min, best_t;
  float size;  // sum of |direction|
  int32_t best;
  int32_t excluded[2];
};

template <class Axes, class Ray, class Given>
bool OneRay::setup_each(const Ray& to, const Given& given, const SceneBox& scene) {
  // Loads of 4 read the number behind each of the two arrays; it is a member of the ray, too.
  const auto from =
      Axes::load_unaligned_each([&](size_t r) { return given(r)->origin; }).without_fourth();
  const auto along =
      Axes::load_unaligned_each([&](size_t r) { return given(r)->direction; }).without_fourth();
  const auto lower = Axes::load_each([&](size_t) { return scene.lower; });
  const auto upper = Axes::load_each([&](size_t) { return scene.upper; });
  const auto longest = along.size();
  const auto total = longest.template component<0>() + longest.template component<1>() +
                     longest.template component<2>();
  const auto infinite = Axes::all(__builtin_inff());
  bool is_valid = (from.size() < infinite).is_all() && (total < infinite).is_all() &&
                  (Axes::all(0) < total).is_all();
  for (size_t r = 0; r < Axes::kRays; ++r) is_valid &= given(r)->t_min <= given(r)->t_max;
  if (!is_valid) return false;

  const auto reach = (lower - from).size().larger((upper - from).size()).greatest();
  const uint32_t is_main = (longest == longest.greatest()).bits();
  from.store_each([&](size_t r) { return to(r)->origin; });
  along.store_each([&](size_t r) { return to(r)->direction; });
  for (size_t r = 0; r < Axes::kRays; ++r) {
    OneRay& ray = *to(r);
    ray.reach = reach.of(r, 0);
    ray.size = total.of(r, 0);
    ray.set_main_axis(is_main >> 4 * r & 15);
  }
  auto slope = along, inverse = along, pad = along;
  set_slopes(to, slope, inverse, pad, reach);
  for (size_t r = 0; r < Axes::kRays; ++r) {
    OneRay& ray = *to(r);
    const SingleRay& own = *given(r);
    ray.t_min = own.t_min;
    for (int k = 0; k < 2; ++k) ray.excluded[k] = static_cast<int32_t>(own.excluded[k]);
    ray.best_t = own.t_max;
    ray.best = -1;
    ray.near_limit = moved(ray.t_min * ray.scale, -kTimeSlack);
    ray.far_limit = moved(ray.best_t * ray.scale, kTimeSlack);
  }
  return true;
}

// Scales the slope so that no product of a coordinate with an inverse overflows: the inverse is at
// most 2^60 for coordinates below 2^60 and at most 1 beyond.
inline void BoxRay::scale_slope() {
  const float wanted = reach < 0x1p60f ? 1.0f : 0x1p60f;
  float largest = max_of(max_of(abs_of(slope[0]), abs_of(slope[1])), abs_of(slope[2]));
  if (largest > wanted * 0x1p-20f && largest < wanted * 0x1p20f) return;
  while (!(largest >= wanted && largest < 2 * wanted)) {
    const float factor = largest < wanted ? 2 : 0.5f;
    for (float& s : slope) s *= factor;
    largest *= factor;
    scale /= factor;
  }
}

// An axis along which the ray hardly moves counts as steeper than it is. The ray leaves the scene
// within t = reach / largest (twice that with all roundings), so it moves by less than `least`
// times that along it.
template <class Axes, class Ray>
void BoxRay::set_slopes(const Ray& to, Axes& slope, Axes& inverse, Axes& pad, Axes reach) {
  const auto slopes = [&](size_t r) { return to(r)->slope; };
  slope.store_each(slopes);
  for (size_t r = 0; r < Axes::kRays; ++r) to(r)->scale = 1;
  auto largest = slope.size().greatest();
  const auto wanted = Axes::all(0x1p60f).where(Axes::all(0x1p60f) <= reach, Axes::all(1));
  const bool is_usual = (wanted * Axes::all(0x1p-20f) < largest).is_all() &&
                        (largest < wanted * Axes::all(0x1p20f)).is_all();
  if (HWY_UNLIKELY(!is_usual)) {
    for (size_t r = 0; r < Axes::kRays; ++r) to(r)->scale_slope();
    slope = Axes::load_each(slopes);
    largest = slope.size().greatest();
  }
  const auto least = largest * Axes::all(0x1p-40f), widest = Axes::all(4) * (reach / largest);
  const auto is_flat = slope.size() < least;
  const auto used = least.with_sign(slope).where(is_flat, slope);
  pad = widest.or_zero(is_flat);
  inverse = Axes::all(1) / used;
  pad.store_each([&](size_t r) { return to(r)->pad; });
  inverse.store_each([&](size_t r) { return to(r)->inverse; });
  const uint32_t down = (used < Axes::all(0)).bits();
  for (size_t r = 0; r < Axes::kRays; ++r) to(r)->down = down >> 4 * r & 7;
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
