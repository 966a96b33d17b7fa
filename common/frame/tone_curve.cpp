// SPDX-License-Identifier: Apache-2.0
#include "common/frame/tone_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace tessera {
namespace {

constexpr std::string_view kNames[kToneCurves] = {"linear", "filmic", "aces", "agx"};
constexpr double kMiddleGrey = 0.18;

using Color = std::array<double, 3>;
using Matrix = std::array<Color, 3>;  // rows

Color times(const Matrix& m, const Color& c) {
  Color result{};
  for (std::size_t row = 0; row < 3; ++row)
    result[row] = m[row][0] * c[0] + m[row][1] * c[1] + m[row][2] * c[2];
  return result;
}

Matrix inverse(const Matrix& m) {
  const auto minor_of = [&m](std::size_t row, std::size_t column) {
    const std::size_t r = (row + 1) % 3, s = (row + 2) % 3;
    const std::size_t c = (column + 1) % 3, d = (column + 2) % 3;
    return m[r][c] * m[s][d] - m[r][d] * m[s][c];
  };
  const double determinant =
      m[0][0] * minor_of(0, 0) + m[0][1] * minor_of(0, 1) + m[0][2] * minor_of(0, 2);
  Matrix result{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      result[row][column] = minor_of(column, row) / determinant;
  }
  return result;
}

constexpr Matrix kIdentity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

// Hill: sRGB to the rendering space of ACES with its desaturation, and back.
constexpr Matrix kAcesIn{
    {{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}}};
constexpr Matrix kAcesOut{
    {{1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}}};
// Sobotka: the inset of the primaries, which turns bright saturated light white as film does.
constexpr Matrix kAgxIn{{{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                         {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                         {0.0423756549057051, 0.0784336, 0.879142973793104}}};

// Requires: x >= 0.
double filmic(double x) {
  constexpr double a = 0.15, b = 0.50, c = 0.10, d = 0.20, e = 0.02, f = 0.30, white = 11.2;
  const auto curve = [&](double v) {
    return (v * (a * v + c * b) + d * e) / (v * (a * v + b) + d * f) - e / f;
  };
  return curve(x) / curve(white);
}

double aces(double x) {
  return (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
}

// 16.5 stops around middle grey become [0, 1]; a sigmoid of slope 2 through (20/33, 1/2) that ends
// in (0, 0) and (1, 1) bends them; 2.2 is the gamma of the display that the curve is made for.
double agx(double x) {
  constexpr double low_ev = -12.473931188332413, stops = 16.5, pivot = 20.0 / 33, slope = 2;
  if (!(x > 0)) return 0;
  const double at = std::clamp((std::log2(x) - low_ev) / stops, 0.0, 1.0);
  const double power = at < pivot ? 3.0 : 3.25;
  const double reach = at < pivot ? pivot : 1 - pivot;
  // The end of each half lies half a unit from the middle: slope * reach / bend(reach) = 1/2.
  const double scale = (std::pow(2 * slope * reach, power) - 1) / std::pow(reach, power);
  const double off = at - pivot;
  const double bend = std::pow(1 + scale * std::pow(std::fabs(off), power), 1 / power);
  return std::pow(std::max(0.5 + slope * off / bend, 0.0), 2.2);
}

// Form of all curves: one matrix, one rising function of each component, another matrix.
struct Curve {
  Matrix in, out, in_inverse, out_inverse;
  double (*of)(double);
  double scale;  // of the input

  Color apply(const Color& c) const {
    Color bent = times(in, {c[0] * scale, c[1] * scale, c[2] * scale});
    for (double& x : bent) x = of(std::max(x, 0.0));
    return times(out, bent);
  }
};

// Returns: where the rising function `of` reaches y, from 2^-149 to 2^kExposureEvMax. It is found
// by bisection over the stops; 100 halvings leave less than double's rounding.
double solve(double (*of)(double), double y) {
  double low_ev = -149, high_ev = kExposureEvMax;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low_ev + high_ev);
    (of(std::exp2(middle)) <= y ? low_ev : high_ev) = middle;
  }
  return std::exp2(low_ev);
}

Curve make_curve(const Matrix& in, const Matrix& out, double (*of)(double)) {
  Curve curve{in, out, inverse(in), inverse(out), of, 1};
  // Grey stays grey but for the last digits of the matrices' rows, whose sums are nearly 1; what
  // that does to green is taken out in a few steps.
  double scale = solve(of, kMiddleGrey) / kMiddleGrey;
  for (int i = 0; i < 3; ++i) {
    curve.scale = scale;
    const double green = curve.apply({kMiddleGrey, kMiddleGrey, kMiddleGrey})[1];
    scale *= solve(of, kMiddleGrey) / solve(of, green);
  }
  return curve;
}

const Curve& curve_of(ToneCurve tone) {
  static const Curve curves[kToneCurves - 1] = {
      make_curve(kIdentity, kIdentity, &filmic),
      make_curve(kAcesIn, kAcesOut, &aces),
      make_curve(kAgxIn, inverse(kAgxIn), &agx),
  };
  return curves[static_cast<int>(tone) - 1];
}

float unit(double x) { return x > 0 ? static_cast<float>(std::min(x, 1.0)) : 0.0f; }

// Input that curves can work with; NaN becomes 0 and infinity 2^64.
double bounded(float x, double gain) { return x > 0 ? std::min(x * gain, 0x1p64) : 0; }

}  // namespace

std::string_view tone_curve_name(ToneCurve curve) { return kNames[static_cast<int>(curve)]; }

Result<ToneCurve> parse_tone_curve(std::string_view text) {
  for (int i = 0; i < kToneCurves; ++i) {
    if (text == kNames[i]) return static_cast<ToneCurve>(i);
  }
  return Status::invalid_argument("--tone " + std::string(text) +
                                  ": give linear, filmic, aces or agx");
}

Vec3f displayed(Vec3f radiance, const DisplayTransform& t) {
  const double gain = std::exp2(double{t.exposure_ev});
  const Color c{bounded(radiance.x, gain), bounded(radiance.y, gain), bounded(radiance.z, gain)};
  const Color shown = t.tone == ToneCurve::kLinear ? c : curve_of(t.tone).apply(c);
  return {unit(shown[0]), unit(shown[1]), unit(shown[2])};
}

Vec3f radiance_of(Vec3f light, const DisplayTransform& t) {
  constexpr double kBrightest = 0.999;
  const double gain = std::exp2(double{t.exposure_ev});
  Color c{};
  for (std::size_t a = 0; a < 3; ++a)
    c[a] = std::min(double{unit(light[static_cast<int>(a)])}, kBrightest);
  if (t.tone != ToneCurve::kLinear) {
    const Curve& curve = curve_of(t.tone);
    Color bent = times(curve.out_inverse, c);
    for (double& x : bent) x = x > 0 ? solve(curve.of, std::min(x, kBrightest)) : 0;
    c = times(curve.in_inverse, bent);
    for (double& x : c) x /= curve.scale;
  }
  const auto component = [&](double x) { return static_cast<float>(std::max(x, 0.0) / gain); };
  return {component(c[0]), component(c[1]), component(c[2])};
}

ToneTable tone_table(ToneCurve tone) {
  const Curve& curve = curve_of(tone);
  ToneTable table{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      table.in[row][column] = static_cast<float>(curve.in[row][column] * curve.scale);
      table.out[row][column] = static_cast<float>(curve.out[row][column]);
    }
  }
  for (int i = 0; i < ToneTable::kSamples; ++i) {
    const double share = static_cast<double>(i) / (ToneTable::kSamples - 1);
    const double ev = ToneTable::kLowEv + (ToneTable::kHighEv - ToneTable::kLowEv) * share;
    table.of[i] = static_cast<float>(curve.of(std::exp2(ev)));
  }
  return table;
}

}  // namespace tessera
