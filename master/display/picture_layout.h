// SPDX-License-Identifier: Apache-2.0
// Where the picture lies in the window, when the window's size counts, and what colour stands for a
// slave: the pure part of drawing.
//
// Threads. Plain values; ResizeDebounce has one owner.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace tessera::master {

struct PixelRect {
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;
  bool operator==(const PixelRect&) const = default;
};

struct PixelSize {
  int width_px = 0, height_px = 0;
  bool operator==(const PixelSize&) const = default;
};

// The greatest rectangle of the picture's aspect inside the window, centred; the whole window when
// the sizes agree. Requires: all at least 1.
PixelRect letterbox(PixelSize picture, PixelSize window);

// A person drags the border through hundreds of sizes; frames are asked for in a size that has
// stood still. One step after a time of quiet (a maximised window, a tile of the desktop) counts at
// once.
class ResizeDebounce {
 public:
  static constexpr double kQuietSeconds = 0.15;
  static constexpr int kSideMinPx = 16;

  // side_max_px: the least of kImageSideMaxPx and what the display can hold.
  ResizeDebounce(PixelSize first, int side_max_px);

  // A side of 0 (minimised window) is not a size to render at and is ignored.
  void on_resize(PixelSize size, double now_seconds);
  // Returns: the new size once it counts and differs from the last one.
  std::optional<PixelSize> poll(double now_seconds);
  PixelSize size() const { return settled_; }

 private:
  PixelSize clamped(PixelSize size) const;

  int side_max_px_;
  PixelSize settled_, wanted_;
  double changed_seconds_ = -kQuietSeconds;
  double counts_at_seconds_ = 0;  // when wanted_ counts
};

// The colour of a slave, sRGB-encoded, [0, 1]. Slaves with neighbouring numbers are far apart in
// hue; the first 12 are easy to tell apart.
std::array<float, 3> slave_colour(std::uint16_t ordinal);

// How strongly a tint covers the picture.
inline constexpr float kTintWeight = 0.35f;

}  // namespace tessera::master
