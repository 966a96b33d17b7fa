// SPDX-License-Identifier: Apache-2.0
// Light of an environment map (sky_map.h), one direction per lane. Values that lie far apart in
// memory are fetched for a whole register before any of them is used, so that the waits overlap.
//
// Threads. Works on the caller's memory.
#include "slave/core/light/sky_layout.h"

#if defined(TESSERA_CORE_SKY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SKY_INL_H_
#undef TESSERA_CORE_SKY_INL_H_
#else
#define TESSERA_CORE_SKY_INL_H_
#endif

#include "slave/core/sampling/hemisphere-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// Lookups in the picture, and samples of it. T: float, or Floats.
template <class T>
class SkyPicture {
  using I = IntOf<T>;
  static constexpr size_t kLanes = kLanesOf<T>;

 public:
  // A place in the picture, in texels from the upper left corner.
  struct Place {
    T x, y;
  };
  struct Sample {
    Vec3<T> direction;  // unit
    Vec3<T> radiance;
    T angle;  // 1 over the pdf by solid angle; 0: take nothing
  };

  // 2 pi^2: the picture's sides as angles, multiplied
  static constexpr float kTwoPi2 = 19.7392088f;

  explicit TESSERA_INLINE SkyPicture(const SkyView& sky) : sky_(sky) {}

  // Bilinear lookup; columns wrap around. wanted: bits of lanes; the others may hold anything.
  TESSERA_INLINE Vec3<T> radiance_at(Place place, uint32_t wanted) const {
    const T x = place.x - 0.5f, y = place.y - 0.5f;
    const T left = floor(x), top = floor(y);
    const I width = set<I>(sky_.width), last_column = width - 1;
    const int32_t last_row = sky_.height - 1;
    const auto column_of = [&](I c) {
      const I before = select(c < 0, c + width, c);
      const I wrapped = select(before > last_column, before - width, before);
      return max(min(wrapped, last_column), 0);  // lanes that are not wanted may hold anything
    };
    const auto row_of = [&](I r) { return max(min(r, last_row), 0) * width; };
    const I c = convert<I>(left), r = convert<I>(top);
    const I columns[2] = {column_of(c), column_of(c + 1)};
    const I above = row_of(r), below = row_of(r + 1);
    Texels texels;
    store(above + columns[0], texels.index[0]);
    store(above + columns[1], texels.index[1]);
    store(below + columns[0], texels.index[2]);
    store(below + columns[1], texels.index[3]);
    for_each_lane(wanted, [&](size_t lane) {
      for (size_t k = 0; k < 4; ++k) {
        const float* const from = sky_.rgb + 3 * static_cast<size_t>(texels.index[k][lane]);
        for (size_t a = 0; a < 3; ++a) texels.rgb[k][a][lane] = from[a];
      }
    });
    const auto mixed = [&](Vec3<T> a, Vec3<T> b, T t) { return a * (1 - t) + b * t; };
    const T right_share = x - left;
    const auto texel = [&](size_t k) { return load3<T>(texels.rgb[k], 0); };
    return mixed(mixed(texel(0), texel(1), right_share), mixed(texel(2), texel(3), right_share),
                 y - top);
  }

  // How much likelier a sample takes the texel of a place than one that is uniform over the
  // picture.
  TESSERA_INLINE T chance_at(Place place, uint32_t wanted) const {
    const auto inside = [&](T x, int32_t count) { return max(min(convert<I>(x), count - 1), 0); };
    alignas(sizeof(T)) int32_t column[kLanes], row[kLanes];
    alignas(sizeof(T)) float chance[kLanes] = {};
    store(inside(place.x, sky_.width), column);
    store(inside(place.y, sky_.height), row);
    for_each_lane(wanted, [&](size_t lane) {
      chance[lane] = chance_of(static_cast<size_t>(column[lane]), static_cast<size_t>(row[lane]));
    });
    return load<T>(chance);
  }

  // x, y: of the unit square, by lane. Column 0 looks along +z, the middle one along -z.
  TESSERA_INLINE Sample sample(const float* x, const float* y, uint32_t wanted) const {
    const Picks picks = pick(x, y, wanted);
    const Place place{load<T>(picks.x), load<T>(picks.y)};
    const auto polar = sin_cos_whole_turn(place.y / static_cast<float>(sky_.height) * 0.5f);
    const auto turn = sin_cos_whole_turn(place.x / static_cast<float>(sky_.width));
    const T chance = load<T>(picks.chance);
    return {{-polar.sin * turn.sin, polar.cos, polar.sin * turn.cos},
            radiance_at(place, wanted),
            zero_unless(chance > 0, kTwoPi2 * polar.sin / chance)};
  }

 private:
  static constexpr float kBelowOne = 1 - kRoundoff;

  template <class Function>
  static TESSERA_INLINE void for_each_lane(uint32_t lanes, const Function& function) {
    for (; lanes != 0; lanes &= lanes - 1) function(static_cast<size_t>(__builtin_ctz(lanes)));
  }

  // The four texels around each place.
  struct Texels {
    alignas(sizeof(T)) int32_t index[4][kLanes];
    alignas(sizeof(T)) float rgb[4][3][kLanes] = {};
  };

  TESSERA_INLINE float chance_of(size_t column, size_t row) const {
    const auto width = static_cast<size_t>(sky_.width);
    const double* const columns = sky_.columns + row * (width + 1);
    return static_cast<float>((sky_.rows[row + 1] - sky_.rows[row]) *
                              (columns[column + 1] - columns[column]) * static_cast<double>(width) *
                              sky_.height);
  }

  struct Picks {
    alignas(sizeof(T)) float x[kLanes] = {}, y[kLanes] = {};  // places
    alignas(sizeof(T)) float chance[kLanes] = {};
  };

  TESSERA_INLINE Picks pick(const float* at_x, const float* at_y, uint32_t wanted) const {
    Picks picks;
    const auto width = static_cast<size_t>(sky_.width), height = static_cast<size_t>(sky_.height);
    size_t rows[kLanes];
    for_each_lane(wanted, [&](size_t lane) {
      rows[lane] = number_at(sky_.rows, sky_.row_guide, height, at_y[lane]);
      const size_t part = part_of(width, at_x[lane]);
      __builtin_prefetch(sky_.column_guide + rows[lane] * width + part);
      __builtin_prefetch(sky_.columns + rows[lane] * (width + 1) + part);
    });
    for_each_lane(wanted, [&](size_t lane) {
      const size_t row = rows[lane];
      const float x = at_x[lane], y = at_y[lane];
      const double* const columns = sky_.columns + row * (width + 1);
      const size_t column = number_at(columns, sky_.column_guide + row * width, width, x);
      picks.x[lane] = static_cast<float>(column) + rest_of(columns, column, x);
      picks.y[lane] = static_cast<float>(row) + rest_of(sky_.rows, row, y);
      picks.chance[lane] = chance_of(column, row);
    });
    return picks;
  }

  static TESSERA_INLINE size_t part_of(size_t count, float x) {
    const auto part = static_cast<size_t>(double{x} * static_cast<double>(count));
    return part < count ? part : count - 1;
  }

  // Returns: the number of the part that holds x. sums [count + 1] are the borders of the parts,
  // from 0 to 1. Requires: 0 <= x < 1. The mean number of steps is 2 at most.
  static TESSERA_INLINE size_t number_at(const double* sums, const uint16_t* guide, size_t count,
                                         float x) {
    size_t number = guide[part_of(count, x)];
    // Where x times count has been rounded up to a whole number, the guide is one part too far.
    while (number > 0 && sums[number] > double{x}) --number;
    while (number + 1 < count && sums[number + 1] <= double{x}) ++number;
    return number;
  }

  static TESSERA_INLINE float rest_of(const double* sums, size_t number, float x) {
    const double chance = sums[number + 1] - sums[number];
    const auto rest = static_cast<float>(chance > 0 ? (double{x} - sums[number]) / chance : 0.5);
    return rest < 0 ? 0 : rest > kBelowOne ? kBelowOne : rest;
  }

  const SkyView& sky_;
};

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#ifndef TESSERA_PLAIN_TEXT

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// The arc tangent of x in [0, 1].
HWY_INLINE Floats arc_tangent(Floats x) {
  const Floats b = x * x;
  Floats sum = set<Floats>(0.0028662257f);
  for (const float c : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                        -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.0f}) {
    sum = sum * b + c;
  }
  return x * sum;
}

// The angle of (x, y) from the x axis, y >= 0: in [0, pi]. 0 for (0, 0).
HWY_INLINE Floats half_angle_of(Floats x, Floats y) {
  constexpr float kPi = 3.14159274f;
  const Floats ax = abs(x);
  const auto is_flat = y <= ax;
  const Floats tangent = arc_tangent(select(is_flat, y, ax) / select(is_flat, ax, y));
  const Floats a = select(is_flat, tangent, kPi / 2 - tangent);
  const Floats angle = select(x < 0, kPi - a, a);
  return zero_if(ax == 0 && y == 0, angle);
}

class SkyKernel {
  using V = Floats;
  using Picture = SkyPicture<V>;

 public:
  SkyKernel(const SkyView& sky, SkyPoints& points) : sky_(sky), p_(points) {}

  // Turns directions into radiance and pdf.
  void look_up() {
    for_each_register([&](size_t at, uint32_t wanted) {
      const Picture picture(sky_);
      const Vec3<V> direction = load3<V>(p_.direction, at);
      const Picture::Place place = place_of(direction);
      store3(picture.radiance_at(place, wanted), p_.radiance, at);
      const V sine = sine_of(direction);
      const V share = picture.chance_at(place, wanted) / (Picture::kTwoPi2 * sine);
      store(zero_unless(sine > 0, share), p_.pdf + at);
    });
  }

  // Turns points of the square into samples: direction, radiance and angle.
  void sample() {
    for_each_register([&](size_t at, uint32_t wanted) {
      const Picture::Sample sample =
          Picture(sky_).sample(p_.square[0] + at, p_.square[1] + at, wanted);
      store3(sample.direction, p_.direction, at);
      store3(sample.radiance, p_.radiance, at);
      store(sample.angle, p_.angle + at);
    });
  }

 private:
  static constexpr float kPi = 3.14159274f;

  template <class Function>
  HWY_INLINE void for_each_register(const Function& function) {
    for (size_t at = 0; at < kSkyPoints; at += kLaneCount) {
      const auto wanted = static_cast<uint32_t>(p_.wanted >> at) & ((1u << kLaneCount) - 1);
      if (wanted != 0) function(at, wanted);
    }
  }

  static HWY_INLINE V sine_of(Vec3<V> d) { return sqrt(d.x * d.x + d.z * d.z); }

  HWY_INLINE Picture::Place place_of(Vec3<V> direction) const {
    const V turn = half_angle_of(-direction.z, abs(direction.x)) / (2 * kPi);
    const V polar = half_angle_of(direction.y, sine_of(direction)) / kPi;
    const V across = select(direction.x < 0, 0.5f - turn, 0.5f + turn);
    return {across * static_cast<float>(sky_.width), polar * static_cast<float>(sky_.height)};
  }

  const SkyView& sky_;
  SkyPoints& p_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
