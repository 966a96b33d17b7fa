// SPDX-License-Identifier: Apache-2.0
// What a small picture of a scene tells: whether the scene's own light shows what the camera sees,
// and the exposure that makes the rest bright enough.
//
// Exposure. The log-average of Reinhard, Stark, Shirley, Ferwerda, "Photographic tone reproduction
// for digital images", 2002, trimmed at both ends: what a picture shows is judged by its middle,
// not by its lamps and cracks.
//
// Threads. Pure functions: the same numbers give the same bits.
#pragma once

#include <span>

namespace tessera::master {

// A surface pixel is seen when it is at most so many stops below the middle of those that are lit:
// six stops below middle grey an 8-bit sRGB display shows code 9 of 255, black in any lit room.
inline constexpr double kSeenStops = 6;
// A scene is lit when so many of the pixels that show a surface are seen. A distant lamp at the
// angle t from the viewer lights (1 + cos t) / 2 of a ball's disc: a quarter at 120 degrees. What
// is lit from further behind is an outline.
inline constexpr double kSeenShareMin = 0.25;

// Shares of the lit pixels that are left out of the mean, the darkest and the brightest.
inline constexpr double kTrimmedDark = 0.10, kTrimmedBright = 0.05;
// Exposure makes the trimmed log-average middle grey.
inline constexpr double kMeteredGrey = 0.18;
// Bounds of automatic exposure, either way: lamps of 1e-7 to 1e7 of one that needs no exposure.
inline constexpr double kAutoExposureEvMax = 24;

// The exposure of a scene that the studio alone lights, from its metered exposure. The studio shows
// white as white at exposure 0, so things up to kBlackStops darker than middle grey are black
// things (coal reflects 0.04, 2.2 stops); what is far darker than any thing, such as a room that
// the studio shines into, lacks light and is exposed as metered, from twice as far on.
inline constexpr float kBlackStops = 1.5f;
float studio_exposure_ev(float metered_ev);

struct Metering {
  double seen_share = 0;  // of the pixels that show a surface; 0 when none does
  float exposure_ev = 0;  // a multiple of 1/64; 0 when nothing is lit
  bool has_surface = false;
};

// Shapes: rgb [3 * count], linear; distance [3 * count], a picture of Renderer::kPrimary, whose
// misses are 0. Pixels that show no surface are left out; where none does, all are metered. A
// number that is negative or not finite counts as black.
Metering meter(std::span<const float> rgb, std::span<const float> distance);

// The trimmed mean of the binary logarithms of all luminances above 0. Returns: false when there
// are none.
bool log_average_ev(std::span<const float> rgb, double& average_ev);

}  // namespace tessera::master
