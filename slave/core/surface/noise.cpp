// SPDX-License-Identifier: Apache-2.0
#include "slave/core/surface/noise.h"

#include <algorithm>
#include <cmath>

namespace tessera::core {
namespace {

constexpr int kOctaves = 6;
static_assert(kNoisePoints * kOctaves <= kNoiseMax);
// Mean of |noise| over space, measured once; a faded octave leaves this.
constexpr float kMeanSize = 0.21f;

// Share of an octave that can be seen. Its wave is one unit: it fades where two footprints are
// wider than that, and is gone where one footprint is.
float shown_of(float footprint) { return std::clamp(2 - 2 * footprint, 0.0f, 1.0f); }

void append(const NoiseArgument& points, float scale, std::uint32_t seed, NoisePoints& to) {
  const std::size_t count = points.x.size(), first = static_cast<std::size_t>(to.count);
  for (std::size_t i = 0; i < count; ++i) {
    to.at[0][first + i] = points.x[i] * scale;
    to.at[1][first + i] = points.y[i] * scale;
    to.at[2][first + i] = points.z[i] * scale;
    to.seed[first + i] = seed;
  }
  to.count += static_cast<int>(count);
}

}  // namespace

void Noise::gradient(const NoiseArgument& points, std::uint32_t seed,
                     std::span<float> noise) const {
  NoisePoints all;
  all.count = 0;
  append(points, 1, seed, all);
  kernel_(all);
  std::copy_n(all.value, noise.size(), noise.begin());
}

void Noise::turbulence(const NoiseArgument& points, std::uint32_t seed,
                       std::span<const float> footprint, std::span<float> sum) const {
  const std::size_t count = sum.size();
  const float finest = *std::min_element(footprint.begin(), footprint.end());
  NoisePoints all;
  all.count = 0;
  std::uint32_t octaves = 0;  // that any of the points shows
  for (float scale = 1; octaves < kOctaves && shown_of(finest * scale) > 0; scale *= 2)
    append(points, scale, seed + octaves++, all);
  kernel_(all);
  std::fill(sum.begin(), sum.end(), 0.0f);
  float scale = 1;
  for (std::uint32_t octave = 0; octave < kOctaves; ++octave, scale *= 2) {
    const float* const value = all.value + octave * count;
    for (std::size_t i = 0; i < count; ++i) {
      const float shown = octave < octaves ? shown_of(footprint[i] * scale) : 0;
      const float size =
          shown > 0 ? std::fabs(value[i]) * shown + kMeanSize * (1 - shown) : kMeanSize;
      sum[i] += size / scale;
    }
  }
}

}  // namespace tessera::core
