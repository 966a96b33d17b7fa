// SPDX-License-Identifier: Apache-2.0
// From linear radiance to what a display shows: exposure, then a tone curve. Linear pixels never
// pass through here; PNG, JPEG, display8 and the window do.
//
// Curves. filmic: Hable, "Uncharted 2: HDR lighting", 2010. aces: Hill's fit of the reference
// rendering and output transforms, in Pettineo and Neubelt, "Baking Lab", 2016. agx: Sobotka,
// "AgX", 2022, its sigmoid in closed form. Each is scaled so that middle grey, 0.18, stays 0.18:
// another curve changes contrast and highlights, and not the brightness of the picture.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/api.h"
#include "common/base/status.h"
#include "common/math/vec3.h"

namespace tessera {

// Values travel on the wire.
enum class ToneCurve : std::uint8_t { kLinear = 0, kFilmic = 1, kAces = 2, kAgx = 3 };
inline constexpr int kToneCurves = 4;

std::string_view tone_curve_name(ToneCurve curve);
Result<ToneCurve> parse_tone_curve(std::string_view text);

// Radiance is multiplied by 2^exposure_ev before the curve.
inline constexpr float kExposureEvMax = 64;  // either way: 2^64 and 2^-64 are floats with room
struct DisplayTransform {
  float exposure_ev = 0;  // in [-kExposureEvMax, kExposureEvMax]
  ToneCurve tone = ToneCurve::kLinear;
  bool is_plain() const { return exposure_ev == 0 && tone == ToneCurve::kLinear; }
  bool operator==(const DisplayTransform&) const = default;
};

// Returns: light of the display, linear, in [0, 1]; NaN and what is negative become 0.
TESSERA_API Vec3f displayed(Vec3f radiance, const DisplayTransform& transform);

// Inverse of displayed(): the radiance that is displayed as `light`, in [0, 1] by component. No
// radiance need reach 1, so that components above 0.999 are taken as 0.999. Colours that the curve
// cannot show are taken to the nearest that it can.
TESSERA_API Vec3f radiance_of(Vec3f light, const DisplayTransform& transform);

// A curve as a table, for tone mapping elsewhere, such as on a window's graphics processor: light
// is out * of(in * radiance), `of` by component. Linear interpolation between the samples is within
// 1e-4 of the curve. Matrices are stored by rows.
struct ToneTable {
  static constexpr int kSamples = 1024;
  static constexpr float kLowEv = -24, kHighEv = 24;  // of the first and the last sample
  float in[3][3], out[3][3];
  float of[kSamples];  // at 2^ev, ev evenly from kLowEv to kHighEv
};
// Requires: not linear, which needs no table.
ToneTable tone_table(ToneCurve tone);

}  // namespace tessera
