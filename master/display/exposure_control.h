// SPDX-License-Identifier: Apache-2.0
// The exposure of a window. It adapts to what is shown, as an eye does, and obeys a person's keys.
//
// Adaptation is relative: when what is shown becomes so many stops brighter than it was at first,
// exposure goes down by as many, exponentially with the time constant of kAdaptSeconds. So the
// first picture has the exposure that was settled for it, background and all.
//
// Threads. One owner (the viewer's thread). Pure: times are passed in.
#pragma once

#include <optional>

#include "common/frame/tone_curve.h"

namespace tessera::master {

class ExposureControl {
 public:
  static constexpr double kAdaptSeconds = 0.4;
  static constexpr float kKeyEv = 1.0f / 3;  // a step of a key, as cameras have it

  // is_automatic: exposure adapts; otherwise only keys change it.
  ExposureControl(const DisplayTransform& start, bool is_automatic)
      : display_(start), start_ev_(start.exposure_ev), is_automatic_(is_automatic) {}

  // Tells the mean brightness of a picture that is shown now. Stops.
  void measured(double average_ev);
  // Returns: whether the exposure changed.
  bool advance(double seconds);

  void nudge(float ev);
  void next_curve();
  // Takes back nudge(). Adaptation goes on, and the tone curve stays.
  void reset();

  const DisplayTransform& display() const { return display_; }
  bool is_settled() const;

 private:
  double target_ev() const;

  DisplayTransform display_;
  float start_ev_;
  bool is_automatic_;
  float by_hand_ev_ = 0;
  double adapted_ev_ = 0;
  std::optional<double> first_ev_, newest_ev_;  // mean stops of pictures
};

}  // namespace tessera::master
