// SPDX-License-Identifier: Apache-2.0
// Which moment of a scene that moves is shown: the clock's, over and over, until a person pauses
// and steps. Frames that come late are left out, since the clock does not wait for them.
//
// Threads. One owner. Pure. Invariant. at() is in [0, duration), and 0 for a duration of 0.
#pragma once

#include <cstdint>

#include "common/base/api.h"
#include "common/base/clock.h"

namespace tessera {

class TESSERA_API Playback {
 public:
  // duration_seconds: after which it begins again; 0: nothing moves; infinity: it goes on for ever.
  // Requires: step_seconds > 0.
  Playback(double duration_seconds, double step_seconds, TimePoint now)
      : duration_seconds_(duration_seconds), step_seconds_(step_seconds), since_(now) {}

  // Seconds of the scene's time.
  double at(TimePoint now) const;
  bool is_paused() const { return is_paused_; }

  // Stops at what is shown now, or goes on from there.
  void set_paused(bool is_paused, TimePoint now);
  // Goes so many frames on, or back, from what is shown now; beyond an end it goes on at the other
  // one, or stops where a scene without an end begins.
  void step(std::int64_t frames, TimePoint now);
  // The scene is another one. What is shown stays at its time where the new one has it.
  void set_duration(double duration_seconds, TimePoint now);

 private:
  double wrapped(double seconds) const;

  double duration_seconds_;
  double step_seconds_;
  bool is_paused_ = false;
  double from_seconds_ = 0;  // the scene's time at since_
  TimePoint since_;
};

}  // namespace tessera
