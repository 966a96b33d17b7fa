// SPDX-License-Identifier: Apache-2.0
#include "master/display/picture_layout.h"

#include <algorithm>
#include <cmath>

namespace tessera::master {

PixelRect letterbox(PixelSize picture, PixelSize window) {
  // Compares window.width / picture.width with window.height / picture.height without dividing.
  const std::int64_t by_width = std::int64_t{window.width_px} * picture.height_px;
  const std::int64_t by_height = std::int64_t{window.height_px} * picture.width_px;
  PixelRect r{0, 0, window.width_px, window.height_px};
  if (by_width < by_height) {
    r.height_px = static_cast<int>(std::max<std::int64_t>(1, by_width / picture.width_px));
  } else {
    r.width_px = static_cast<int>(std::max<std::int64_t>(1, by_height / picture.height_px));
  }
  r.x_px = (window.width_px - r.width_px) / 2;
  r.y_px = (window.height_px - r.height_px) / 2;
  return r;
}

ResizeDebounce::ResizeDebounce(PixelSize first, int side_max_px)
    : side_max_px_(std::max(side_max_px, kSideMinPx)),
      settled_(clamped(first)),
      wanted_(settled_) {}

PixelSize ResizeDebounce::clamped(PixelSize size) const {
  return {std::clamp(size.width_px, kSideMinPx, side_max_px_),
          std::clamp(size.height_px, kSideMinPx, side_max_px_)};
}

void ResizeDebounce::on_resize(PixelSize size, double now_seconds) {
  if (size.width_px <= 0 || size.height_px <= 0) return;
  wanted_ = clamped(size);
  const bool is_first_step = now_seconds - changed_seconds_ >= kQuietSeconds;
  changed_seconds_ = now_seconds;
  counts_at_seconds_ = is_first_step ? now_seconds : now_seconds + kQuietSeconds;
}

std::optional<PixelSize> ResizeDebounce::poll(double now_seconds) {
  if (wanted_ == settled_ || now_seconds < counts_at_seconds_) return std::nullopt;
  settled_ = wanted_;
  return settled_;
}

std::array<float, 3> slave_colour(std::uint16_t ordinal) {
  constexpr double kGoldenRatioConjugate = 0.6180339887498949;  // steps of it spread hues evenly
  const double hue = std::fmod(0.58 + ordinal * kGoldenRatioConjugate, 1.0) * 6;
  const auto channel = [hue](double centre) {
    const double away = std::abs(std::remainder(hue - centre, 6.0));
    return static_cast<float>(0.15 + 0.85 * std::clamp(2 - away, 0.0, 1.0));
  };
  return {channel(0), channel(2), channel(4)};
}

}  // namespace tessera::master
