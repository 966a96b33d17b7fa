// SPDX-License-Identifier: Apache-2.0
// A person, an interactive loop and a cluster in virtual time. The cluster traces `rays_per_second`
// rays a second, one frame after the other, in the order of submission. Frames that are given up
// come back as such after a moment. Everything that happens is recorded.
//
// Threads. One.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "common/base/ids.h"
#include "master/session/interactive_loop.h"

namespace tessera {

struct InteractiveWorld {
  struct Submitted {
    double at = 0;
    FrameSettings settings;
  };
  struct Shown {
    double at = 0;
    FrameSettings settings;
    InteractiveLoop::Arrival arrival;
  };

  explicit InteractiveWorld(const InteractiveOptions& options) : loop(options), options(options) {}

  static double rays(const FrameSettings& s) {
    return 1.0 * s.width_px * s.height_px * s.samples_per_pixel * (1 + s.light_samples);
  }
  double frame_seconds(const FrameSettings& s) const { return rays(s) / rays_per_second; }

  TimePoint time() const { return TimePoint{} + from_seconds(now); }

  void want(const FrameSettings& settings) {
    wanted = settings;
    loop.want(settings, time());
    settle();
  }
  // Asks for another camera than before.
  void move() {
    FrameSettings next = wanted;
    next.camera.eye.x += 0.01f;
    want(next);
  }
  void resize(int width_px, int height_px) {
    FrameSettings next = wanted;
    next.width_px = width_px;
    next.height_px = height_px;
    want(next);
  }

  // Lets `run_seconds` pass.
  void run(double run_seconds) {
    const double end = now + run_seconds;
    while (true) {
      const double next_event = std::min({end, wake_at, next_outcome_at()});
      now = std::max(now, next_event);
      if (next_outcome_at() <= now) {
        deliver();
        settle();
      } else if (wake_at <= now) {
        settle();
      } else {
        return;
      }
    }
  }

  double rays_per_second = 1e7;
  std::size_t slave_count = 1;
  double scene_ready_at = 0;  // seconds; no frame begins earlier

  double now = 0;
  FrameSettings wanted;
  InteractiveLoop loop;
  const InteractiveOptions options;
  std::vector<Submitted> submitted;
  std::vector<Shown> shown;
  std::vector<double> given_up, asked;
  std::size_t in_flight_max = 0;

 private:
  static constexpr double kNever = 1e300;
  static constexpr double kGivenUpAfter = 0.002;  // seconds, over the network thread and back
  struct InWork {
    FrameId id = 0;
    FrameSettings settings;
    double done_at = kNever;
    bool is_given_up = false;
  };

  double next_outcome_at() const { return work_.empty() ? kNever : work_.front().done_at; }

  // The first frame in work begins when the one before it is over and a slave is there.
  void begin_first() {
    if (work_.empty() || work_.front().done_at < kNever || slave_count == 0) return;
    begun_at_ = std::max(now, scene_ready_at);
    work_.front().done_at = begun_at_ + frame_seconds(work_.front().settings);
  }

  void deliver() {
    const InWork done = work_.front();
    work_.pop_front();
    const auto arrival =
        loop.arrived(done.id, !done.is_given_up, frame_seconds(done.settings), time());
    if (!arrival.is_left_behind) shown.push_back({now, done.settings, arrival});
    begin_first();
  }

  void settle() {
    for (int steps = 0; steps < 100; ++steps) {
      const InteractiveLoop::Step step = loop.next(time());
      switch (step.kind) {
        case InteractiveLoop::Step::Kind::kSubmit:
          submitted.push_back({now, step.settings});
          work_.push_back({next_id_, step.settings});
          loop.submitted(next_id_++, time());
          in_flight_max = std::max(in_flight_max, work_.size());
          begin_first();
          continue;
        case InteractiveLoop::Step::Kind::kGiveUp:
          given_up.push_back(now);
          for (InWork& frame : work_) {
            frame.is_given_up = true;
            frame.done_at = now + kGivenUpAfter;
          }
          continue;
        case InteractiveLoop::Step::Kind::kAskStatus:
          asked.push_back(now);
          loop.status_came(slave_count, time());
          begin_first();
          continue;
        case InteractiveLoop::Step::Kind::kWait:
          wake_at = now + step.wait_seconds;
          return;
      }
    }
    is_stuck = true;
  }

  double wake_at = 0;
  double begun_at_ = 0;
  FrameId next_id_ = 0;
  std::deque<InWork> work_;

 public:
  bool is_stuck = false;  // the loop never said that it waits
};

}  // namespace tessera
