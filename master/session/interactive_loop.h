// SPDX-License-Identifier: Apache-2.0
// What an interactive application asks of its cluster next: which frame and how good, which frames
// in work are left behind because nobody would look at them, and when to ask how the cluster is.
// Pure: events and times go in, steps come out, and one thread of the application carries them out.
//
// Frames have one of two uses. While the view moves, *moving* frames follow it, each reduced so
// that it takes the budget. Once it has stood still for kRestSeconds, *resting* frames climb: a
// quarter and a half of each side, then all of it, then further passes, whose mean comes closer
// and closer to the truth. Steps on the way that would be done within the budget are passed over,
// and none shows less than the view's frame before it. The shares are of each side and not of the
// pixels: so the way up costs 1/16 + 1/4 + 1 = 1.3125 full frames, and each step shows twice as
// much detail (shares of the pixels: 1.75 frames, for steps that can hardly be told apart).
//
// These frames are left behind at once: every frame of another size than the one wanted; resting
// frames of another view; moving frames of another view when no slave is there, or when they have
// taken far longer than they were to take. A moving frame that is in time is shown although the
// view has gone on, or a hand that never rests would never see anything.
//
// A new size or another scene is no motion: its frames climb at once. An animated scene never
// rests, until it is paused. Without a budget nothing is reduced, and there is no climbing.
//
// Threads. One owner. Invariants. (1) At most frames_in_flight frames are in flight, those left
// behind included, until their outcome came. (2) Frames in flight that are not left behind are
// either all moving or all resting ones, so all can be given up at once. (3) A view that stands
// still gets its passes, and then no frame more (unless never_rests).
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/base/api.h"
#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/frame/frame_settings.h"
#include "master/session/frame_pacer.h"

namespace tessera {

struct InteractiveOptions {
  double budget_seconds = 0.1;  // that a frame may take while something moves; 0: any time
  int frames_in_flight = 2;     // as the session's
  std::uint32_t passes = 64;    // of a view at rest, at least 1
  bool is_animated = false;     // the scene moves by itself, at first
  bool never_rests = false;     // full frames go on for ever (for who counts them)
  // Longest time by which the next frame is submitted before a moving frame ends: the way to the
  // slaves and back. 15 ms are that of a busy wireless network.
  double lead_seconds_max = 0.015;
};

class TESSERA_API InteractiveLoop {
 public:
  // Time until a view that moved counts as at rest.
  static constexpr double kRestSeconds = 0.2;
  // Time between two questions how the cluster is. A remote session answers with what it heard
  // after the question before, so what a person sees is at most twice as old.
  static constexpr double kStatusSeconds = 0.5;

  explicit InteractiveLoop(const InteractiveOptions& options);

  // Says what the person wants to see, unreduced, as pass 0. Saying the same again is no event.
  void want(const FrameSettings& settings, TimePoint now);

  // Says whether the scene moves by itself from now on.
  void set_animated(bool is_animated);
  // Says that the view's scene is another one: what was shown of it is shown anew.
  void scene_changed();

  struct Step {
    enum class Kind {
      kSubmit,     // submit `settings`, then call submitted()
      kGiveUp,     // give up all frames in flight; their outcomes still come
      kAskStatus,  // ask how the cluster is, then call status_came()
      kWait,       // for an outcome or another wish, at most `wait_seconds`
    };
    Kind kind = Kind::kWait;
    FrameSettings settings;
    double wait_seconds = 0;
  };
  // Call until it says kWait. Requires: want() was called.
  Step next(TimePoint now);

  void submitted(FrameId frame, TimePoint now);
  void status_came(std::size_t slave_count, TimePoint now);

  // What a frame that came is good for.
  struct Arrival {
    bool is_left_behind = false;      // drop it
    bool is_full = false;             // everything that was wanted; its pass belongs to a mean
    std::uint32_t pass = 0;           // 0 begins a new mean
    int width_px = 0, height_px = 0;  // of the picture that it stands for
    double latency_seconds = 0;       // since it was submitted
  };
  // A frame's outcome: finished (in `render_seconds`, from its first lease to its last result), or
  // not. Requires: it was submitted, and outcomes come in the order of submission.
  Arrival arrived(FrameId frame, bool is_finished, double render_seconds, TimePoint now);

  bool has_frames_in_flight() const { return !in_flight_.empty(); }

 private:
  enum class Use { kMoving, kResting };
  struct InFlight {
    FrameId frame = 0;
    FrameSettings settings;
    FrameSettings wanted;  // that it stands for
    Use use = Use::kResting;
    std::uint64_t wish = 0;
    TimePoint submitted;
    bool is_left_behind = false;
  };

  void begin_wish();
  bool is_moving(TimePoint now) const;
  bool must_give_up(TimePoint now);
  bool is_overdue(const InFlight& frame, TimePoint now) const;
  TimePoint begun(const InFlight& frame) const;
  std::optional<FrameSettings> moving_frame(TimePoint now);
  std::optional<FrameSettings> resting_frame();
  std::optional<FrameSettings> step_up() const;
  // When the next moving frame is due for submission, so that it begins as the one in work ends.
  TimePoint moving_due() const;
  double wait_seconds(TimePoint now) const;

  const InteractiveOptions options_;
  bool is_animated_;
  FramePacer pacer_;
  FrameSettings wanted_;
  std::uint64_t wish_ = 0;             // counts what was wanted; 0: nothing yet
  std::optional<TimePoint> moved_;     // when the camera moved last
  std::optional<FrameSettings> best_;  // submitted for this wish
  std::uint32_t pass_ = 0;             // of best_, when that is a full frame
  InFlight proposed_;                  // by the last kSubmit
  std::deque<InFlight> in_flight_;     // in the order of submission
  TimePoint last_arrival_{};
  bool has_measured_ = false;
  bool has_slaves_ = true;
  TimePoint status_due_{};
};

}  // namespace tessera
