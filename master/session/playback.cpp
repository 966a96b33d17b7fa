// SPDX-License-Identifier: Apache-2.0
#include "master/session/playback.h"

#include <cmath>

namespace tessera {

double Playback::wrapped(double scene_seconds) const {
  if (!(duration_seconds_ > 0)) return 0;
  if (std::isinf(duration_seconds_)) return scene_seconds > 0 ? scene_seconds : 0;
  const double rest = std::fmod(scene_seconds, duration_seconds_);
  const double positive = rest < 0 ? rest + duration_seconds_ : rest;
  return positive < duration_seconds_ ? positive : 0;  // a tiny step back may round to the end
}

double Playback::at(TimePoint now) const {
  return wrapped(is_paused_ ? from_seconds_ : from_seconds_ + seconds(now - since_));
}

void Playback::set_paused(bool is_paused, TimePoint now) {
  from_seconds_ = at(now);
  since_ = now;
  is_paused_ = is_paused;
}

void Playback::step(std::int64_t frames, TimePoint now) {
  from_seconds_ = wrapped(at(now) + static_cast<double>(frames) * step_seconds_);
  since_ = now;
}

void Playback::set_duration(double duration_seconds, TimePoint now) {
  const double shown = at(now);
  duration_seconds_ = duration_seconds;
  from_seconds_ = wrapped(shown);
  since_ = now;
}

}  // namespace tessera
