// SPDX-License-Identifier: Apache-2.0
#include "master/look/meter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/check.h"

namespace tessera::master {
namespace {

constexpr double kStep = 1.0 / 64;  // of exposure: less than anybody sees, more than any rounding

// The luminance of Rec. 709; 0 where it is negative or not finite.
double luminance(std::span<const float> rgb, std::size_t pixel) {
  const double y =
      0.2126 * rgb[3 * pixel] + 0.7152 * rgb[3 * pixel + 1] + 0.0722 * rgb[3 * pixel + 2];
  return y > 0 && std::isfinite(y) ? y : 0;
}

// of: logarithms, in any order. Requires: `of` is not empty.
double trimmed_mean(std::vector<double> of) {
  std::sort(of.begin(), of.end());
  const auto count = static_cast<double>(of.size());
  const auto first = static_cast<std::size_t>(kTrimmedDark * count);
  const auto last = of.size() - static_cast<std::size_t>(kTrimmedBright * count);
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += of[i];
  return sum / static_cast<double>(last - first);
}

}  // namespace

Metering meter(std::span<const float> rgb, std::span<const float> distance) {
  TESSERA_CHECK_EQ(rgb.size(), distance.size());
  const std::size_t count = rgb.size() / 3;
  std::size_t surfaces = 0;
  for (std::size_t i = 0; i < count; ++i) surfaces += distance[3 * i] > 0 ? 1u : 0u;
  Metering result;
  result.has_surface = surfaces > 0;
  std::vector<double> lit;
  for (std::size_t i = 0; i < count; ++i) {
    if (result.has_surface && !(distance[3 * i] > 0)) continue;
    const double y = luminance(rgb, i);
    if (y > 0) lit.push_back(std::log2(y));
  }
  if (lit.empty()) return result;
  const double middle = trimmed_mean(lit);
  const auto is_seen = [&](double ev) { return ev >= middle - kSeenStops; };
  const auto seen = std::count_if(lit.begin(), lit.end(), is_seen);
  if (result.has_surface)
    result.seen_share = static_cast<double>(seen) / static_cast<double>(surfaces);
  const double ev =
      std::clamp(std::log2(kMeteredGrey) - middle, -kAutoExposureEvMax, kAutoExposureEvMax);
  result.exposure_ev = static_cast<float>(std::round(ev / kStep) * kStep);
  return result;
}

float studio_exposure_ev(float metered_ev) {
  return std::clamp(2 * (metered_ev - kBlackStops), 0.0f, std::max(metered_ev, 0.0f));
}

bool log_average_ev(std::span<const float> rgb, double& average_ev) {
  std::vector<double> lit;
  for (std::size_t i = 0; i < rgb.size() / 3; ++i) {
    const double y = luminance(rgb, i);
    if (y > 0) lit.push_back(std::log2(y));
  }
  if (lit.empty()) return false;
  average_ev = trimmed_mean(std::move(lit));
  return true;
}

}  // namespace tessera::master
