// SPDX-License-Identifier: Apache-2.0
// Light of an environment map, a direction to a lane; samples to the bit of sky_map.h. What lies far apart in
// memory is fetched for a whole register before any of it is used, so that the waits overlap.
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

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

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

class SkyKernel {
  using D = hn::CappedTag<float, 16>;
  using DI = hn::RebindToSigned<D>;
  using V = hn::Vec<D>;
  using VI = hn::Vec<DI>;
  static constexpr size_t kLanes = hn::MaxLanes(D());

 public:
  SkyKernel(const SkyView& sky, SkyPoints& points) : sky_(sky), p_(points) {}

  // From directions to radiance and pdf.
  void look_up() {
    for_each_register([&](size_t at, uint32_t wanted) {
      const D d;
      const Vec3<D> direction = load3(d, p_.direction, at);
      const Place place = place_of(direction);
      store3(d, radiance_at(place, wanted), p_.radiance, at);
      const V sine = sine_of(direction);
      const V share = hn::Div(chance_at(place, wanted), hn::Mul(hn::Set(d, kTwoPi2), sine));
      hn::Store(hn::IfThenElseZero(hn::Gt(sine, hn::Zero(d)), share), d, p_.pdf + at);
    });
  }

  // From places in the square to samples: direction, radiance and angle.
  void sample() {
    for_each_register([&](size_t at, uint32_t wanted) {
      const D d;
      const Picks picks = pick(at, wanted);
      const Place place{hn::Load(d, picks.x), hn::Load(d, picks.y)};
      const auto part = [&](V x, int32_t count) {
        return hn::Div(x, hn::Set(d, static_cast<float>(count)));
      };
      const auto polar =
          sin_cos_whole_turn(d, hn::Mul(part(place.y, sky_.height), hn::Set(d, 0.5f)));
      const auto turn = sin_cos_whole_turn(d, part(place.x, sky_.width));
      const Vec3<D> direction{hn::Mul(hn::Neg(polar.sin), turn.sin), polar.cos,
                              hn::Mul(polar.sin, turn.cos)};
      store3(d, direction, p_.direction, at);
      store3(d, radiance_at(place, wanted), p_.radiance, at);
      const V chance = hn::Load(d, picks.chance);
      const V angle = hn::Div(hn::Mul(hn::Set(d, kTwoPi2), polar.sin), chance);
      hn::Store(hn::IfThenElseZero(hn::Gt(chance, hn::Zero(d)), angle), d, p_.angle + at);
    });
  }

 private:
  static constexpr float kTwoPi2 =
      19.7392088f;  // 2 pi^2: the picture's sides as angles, multiplied
  static constexpr float kPi = 3.14159274f;
  static constexpr float kBelowOne = 1 - kRoundoff;

  // In texels, from the upper left corner.
  struct Place {
    V x, y;
  };

  template <class Function>
  HWY_INLINE void for_each_register(const Function& function) {
    for (size_t at = 0; at < kSkyPoints; at += kLanes) {
      const auto wanted = static_cast<uint32_t>(p_.wanted >> at) & ((1u << kLanes) - 1);
      if (wanted != 0) function(at, wanted);
    }
  }
  template <class Function>
  static HWY_INLINE void for_each_lane(uint32_t lanes, const Function& function) {
    for (; lanes != 0; lanes &= lanes - 1) function(static_cast<size_t>(__builtin_ctz(lanes)));
  }

  static HWY_INLINE V sine_of(Vec3<D> d) {
    return hn::Sqrt(hn::Add(hn::Mul(d.x, d.x), hn::Mul(d.z, d.z)));
  }

  static HWY_INLINE Place place_from(V turn, V polar, V x, float width, float height) {
    const D d;
    const V half = hn::Set(d, 0.5f);
    const V across =
        hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(half, turn), hn::Add(half, turn));
    return {hn::Mul(across, hn::Set(d, width)), hn::Mul(polar, hn::Set(d, height))};
  }

  HWY_INLINE Place place_of(Vec3<D> direction) const {
    const D d;
    const V turn =
        hn::Div(half_angle_of(d, hn::Neg(direction.z), hn::Abs(direction.x)), hn::Set(d, 2 * kPi));
    const V polar = hn::Div(half_angle_of(d, direction.y, sine_of(direction)), hn::Set(d, kPi));
    return place_from(turn, polar, direction.x, static_cast<float>(sky_.width),
                      static_cast<float>(sky_.height));
  }

  // Bilinear; columns repeat.
  HWY_INLINE Vec3<D> radiance_at(Place place, uint32_t wanted) const {
    const D d;
    const DI di;
    const V x = hn::Sub(place.x, hn::Set(d, 0.5f)), y = hn::Sub(place.y, hn::Set(d, 0.5f));
    const V left = hn::Floor(x), top = hn::Floor(y);
    const VI one = hn::Set(di, 1), width = hn::Set(di, sky_.width);
    const VI last_column = hn::Sub(width, one), last_row = hn::Set(di, sky_.height - 1);
    const auto clamped = [&](VI v, VI last) { return hn::Max(hn::Min(v, last), hn::Zero(di)); };
    const auto column_of = [&](VI c) {
      const VI before = hn::IfThenElse(hn::Lt(c, hn::Zero(di)), hn::Add(c, width), c);
      const VI wrapped =
          hn::IfThenElse(hn::Gt(before, last_column), hn::Sub(before, width), before);
      return clamped(wrapped, last_column);  // whatever the lanes are that are not wanted
    };
    const VI c = hn::ConvertTo(di, left), r = hn::ConvertTo(di, top);
    const VI columns[2] = {column_of(c), column_of(hn::Add(c, one))};
    const VI above = hn::Mul(clamped(r, last_row), width),
             below = hn::Mul(clamped(hn::Add(r, one), last_row), width);
    Texels texels;
    hn::Store(hn::Add(above, columns[0]), di, texels.index[0]);
    hn::Store(hn::Add(above, columns[1]), di, texels.index[1]);
    hn::Store(hn::Add(below, columns[0]), di, texels.index[2]);
    hn::Store(hn::Add(below, columns[1]), di, texels.index[3]);
    for_each_lane(wanted, [&](size_t lane) {
      for (size_t k = 0; k < 4; ++k) {
        const float* const from = sky_.rgb + 3 * static_cast<size_t>(texels.index[k][lane]);
        for (size_t a = 0; a < 3; ++a) texels.rgb[k][a][lane] = from[a];
      }
    });
    const auto mixed = [&](Vec3<D> a, Vec3<D> b, V t) {
      return a * hn::Sub(hn::Set(d, 1), t) + b * t;
    };
    const V right_share = hn::Sub(x, left);
    const auto texel = [&](size_t k) { return load3(d, texels.rgb[k], 0); };
    return mixed(mixed(texel(0), texel(1), right_share), mixed(texel(2), texel(3), right_share),
                 hn::Sub(y, top));
  }

  // The four of each point.
  struct Texels {
    alignas(64) int32_t index[4][kLanes];
    alignas(64) float rgb[4][3][kLanes] = {};
  };

  // How much likelier than uniformly over the picture samples take this texel.
  HWY_INLINE float chance_of(size_t column, size_t row) const {
    const auto width = static_cast<size_t>(sky_.width);
    const double* const columns = sky_.columns + row * (width + 1);
    return static_cast<float>((sky_.rows[row + 1] - sky_.rows[row]) *
                              (columns[column + 1] - columns[column]) * static_cast<double>(width) *
                              sky_.height);
  }

  HWY_INLINE V chance_at(Place place, uint32_t wanted) const {
    const D d;
    const DI di;
    const auto inside = [&](V x, int32_t count) {
      return hn::Max(hn::Min(hn::ConvertTo(di, x), hn::Set(di, count - 1)), hn::Zero(di));
    };
    alignas(64) int32_t column[kLanes], row[kLanes];
    alignas(64) float chance[kLanes] = {};
    hn::Store(inside(place.x, sky_.width), di, column);
    hn::Store(inside(place.y, sky_.height), di, row);
    for_each_lane(wanted, [&](size_t lane) {
      chance[lane] = chance_of(static_cast<size_t>(column[lane]), static_cast<size_t>(row[lane]));
    });
    return hn::Load(d, chance);
  }

  struct Picks {
    alignas(64) float x[kLanes] = {}, y[kLanes] = {};  // places
    alignas(64) float chance[kLanes] = {};
  };

  HWY_INLINE Picks pick(size_t at, uint32_t wanted) const {
    Picks picks;
    const auto width = static_cast<size_t>(sky_.width), height = static_cast<size_t>(sky_.height);
    size_t rows[kLanes];
    for_each_lane(wanted, [&](size_t lane) {
      rows[lane] = number_at(sky_.rows, sky_.row_guide, height, p_.square[1][at + lane]);
      const size_t part = part_of(width, p_.square[0][at + lane]);
      __builtin_prefetch(sky_.column_guide + rows[lane] * width + part);
      __builtin_prefetch(sky_.columns + rows[lane] * (width + 1) + part);
    });
    for_each_lane(wanted, [&](size_t lane) {
      const size_t row = rows[lane];
      const float x = p_.square[0][at + lane], y = p_.square[1][at + lane];
      const double* const columns = sky_.columns + row * (width + 1);
      const size_t column = number_at(columns, sky_.column_guide + row * width, width, x);
      picks.x[lane] = static_cast<float>(column) + rest_of(columns, column, x);
      picks.y[lane] = static_cast<float>(row) + rest_of(sky_.rows, row, y);
      picks.chance[lane] = chance_of(column, row);
    });
    return picks;
  }

  static HWY_INLINE size_t part_of(size_t count, float x) {
    const auto part = static_cast<size_t>(double{x} * static_cast<double>(count));
    return part < count ? part : count - 1;
  }

  static HWY_INLINE size_t number_at(const double* sums, const uint16_t* guide, size_t count,
                                     float x) {
    size_t number = guide[part_of(count, x)];
    // Where x times count has been rounded up to a whole number, it is one part too far.
    while (number > 0 && sums[number] > double{x}) --number;
    while (number + 1 < count && sums[number + 1] <= double{x}) ++number;
    return number;
  }

  static HWY_INLINE float rest_of(const double* sums, size_t number, float x) {
    const double chance = sums[number + 1] - sums[number];
    const auto rest = static_cast<float>(chance > 0 ? (double{x} - sums[number]) / chance : 0.5);
    return rest < 0 ? 0 : rest > kBelowOne ? kBelowOne : rest;
  }

  const SkyView& sky_;
  SkyPoints& p_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
