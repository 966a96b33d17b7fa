// How much of the picture's quality a moving camera can have: while the view changes, frames are
// made to take the time asked for, first by fewer samples, then by fewer pixels; once it has stood
// still for a moment, the next frame has everything again. Pure.
//
// What the cluster can do is measured in pixel samples per second, from the frames that came; so a
// slave more or less changes the next frame's size.
//
// Threads. One owner. Invariant. 0 < scale <= 1 and 1 <= samples <= those asked for.
#pragma once

#include <cstdint>

#include "common/base/clock.h"
#include "common/frame/frame_settings.h"

namespace tessera::master {

class FramePacer {
 public:
  // Until a view that stood still counts as at rest.
  static constexpr double kRestSeconds = 0.2;
  static constexpr double kScaleMin = 0.125;

  // target_seconds 0: never reduces anything.
  explicit FramePacer(double target_seconds) : target_seconds_(target_seconds) {}

  // The view is another one than before.
  void moved(TimePoint now);
  bool is_moving(TimePoint now) const;

  // `wanted` as it can be had now: size, samples per pixel, samples per light or VPLs reduced
  // while moving.
  FrameSettings settings(const FrameSettings& wanted, TimePoint now);

  // A frame came `frame_seconds` after the one before it, or after its submission if there was
  // none.
  void frame_done(const FrameSettings& settings, double frame_seconds);

  // Is a frame with these settings in the way of what the person does? A full one is, while the
  // view moves, if it takes longer than a moving frame may.
  bool is_left_behind(const FrameSettings& settings, const FrameSettings& wanted,
                      TimePoint now) const;

 private:
  double seconds_for(const FrameSettings& settings) const;

  const double target_seconds_;
  TimePoint moved_at_{};
  bool has_moved_ = false;
  double work_per_second_ = 0;  // pixel samples, recent mean
  double scale_ = 1;            // last one given while moving
};

}  // namespace tessera::master
