// SPDX-License-Identifier: Apache-2.0
#include "master/session/interactive_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/check.h"

namespace tessera {
namespace {

// Shares of each side, on the way up to 1.
constexpr std::array<double, 2> kSteps{0.25, 0.5};
// A reduced picture of all pixels is worth a frame only when the whole one takes this much longer.
constexpr double kWorthStep = 4;
// A moving frame may take so many times what it was to take.
constexpr double kPatience = 2;
// The next moving frame is submitted this share of the present one's time before that one ends, but
// no longer before it than the way to the slaves takes. The slaves need the frame before they run
// out of tiles, and all that the person does after its submission waits for the frame behind it.
constexpr double kLeadShare = 0.25;
constexpr double kWaitSecondsMin = 0.001;

bool is_of_size(const FrameSettings& a, const FrameSettings& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px;
}

}  // namespace

InteractiveLoop::InteractiveLoop(const InteractiveOptions& options)
    : options_(options), is_animated_(options.is_animated), pacer_(options.budget_seconds) {}

void InteractiveLoop::want(const FrameSettings& settings, TimePoint now) {
  if (wish_ > 0 && settings == wanted_) return;
  if (wish_ > 0 && is_of_size(settings, wanted_)) moved_ = now;
  wanted_ = settings;
  begin_wish();
}

void InteractiveLoop::set_animated(bool is_animated) {
  if (std::exchange(is_animated_, is_animated) != is_animated) scene_changed();
}

void InteractiveLoop::scene_changed() {
  if (wish_ > 0) begin_wish();
}

void InteractiveLoop::begin_wish() {
  ++wish_;
  best_.reset();
  pass_ = 0;
}

bool InteractiveLoop::is_moving(TimePoint now) const {
  if (options_.never_rests) return false;
  return is_animated_ || (moved_ && seconds(now - *moved_) < kRestSeconds);
}

TimePoint InteractiveLoop::begun(const InFlight& frame) const {
  return std::max(frame.submitted, last_arrival_);
}

bool InteractiveLoop::is_overdue(const InFlight& frame, TimePoint now) const {
  if (options_.budget_seconds <= 0 || !has_measured_ || !has_slaves_) return false;
  const double allowed =
      kPatience * std::max(options_.budget_seconds, pacer_.expected_seconds(frame.settings));
  if (seconds(now - begun(frame)) <= allowed) return false;
  // A smaller frame must be possible, or giving up would go on for ever.
  FramePacer slower = pacer_;
  slower.frame_overdue(frame.settings, seconds(now - begun(frame)));
  return FramePacer::is_better(frame.settings, slower.moving(wanted_));
}

bool InteractiveLoop::must_give_up(TimePoint now) {
  bool must = false;
  for (std::size_t i = 0; i < in_flight_.size(); ++i) {
    const InFlight& frame = in_flight_[i];
    if (frame.is_left_behind || frame.wish == wish_) continue;
    if (!is_of_size(frame.wanted, wanted_)) {
      must = true;
    } else if (frame.use == Use::kResting) {
      // Without a budget the first pass is all that a moving hand sees.
      must = must || options_.budget_seconds > 0 || frame.settings.pass > 0;
    } else if (!has_slaves_) {
      must = true;
    } else if (i == 0 && is_overdue(frame, now)) {
      pacer_.frame_overdue(frame.settings, seconds(now - begun(frame)));
      must = true;
    }
  }
  return must;
}

InteractiveLoop::Step InteractiveLoop::next(TimePoint now) {
  TESSERA_CHECK_GE(wish_, 1u);
  Step step;
  if (must_give_up(now)) {
    for (InFlight& frame : in_flight_) frame.is_left_behind = true;
    step.kind = Step::Kind::kGiveUp;
    return step;
  }
  if (now >= status_due_) {
    step.kind = Step::Kind::kAskStatus;
    status_due_ = now + from_seconds(kStatusSeconds);
    return step;
  }
  if (in_flight_.size() < static_cast<std::size_t>(options_.frames_in_flight)) {
    const bool moves = is_moving(now);
    if (const auto settings = moves ? moving_frame(now) : resting_frame()) {
      proposed_ = {0, *settings, wanted_, moves ? Use::kMoving : Use::kResting, wish_, now, false};
      step.kind = Step::Kind::kSubmit;
      step.settings = *settings;
      return step;
    }
  }
  step.wait_seconds = wait_seconds(now);
  return step;
}

std::optional<FrameSettings> InteractiveLoop::moving_frame(TimePoint now) {
  if (best_ && !is_animated_) return std::nullopt;  // it is on its way
  if (now < moving_due()) return std::nullopt;
  return pacer_.moving(wanted_);
}

TimePoint InteractiveLoop::moving_due() const {
  if (in_flight_.empty() || in_flight_.back().is_left_behind) return TimePoint{};
  const InFlight& last = in_flight_.back();
  const double expected = pacer_.expected_seconds(last.settings);
  if (!std::isfinite(expected)) return TimePoint::max();
  const double lead = std::min(options_.lead_seconds_max, kLeadShare * expected);
  return begun(last) + from_seconds(expected - lead);
}

std::optional<FrameSettings> InteractiveLoop::resting_frame() {
  for (const InFlight& frame : in_flight_) {
    if (!frame.is_left_behind && frame.use == Use::kMoving) return std::nullopt;
  }
  if (!best_ || FramePacer::is_better(wanted_, *best_)) return step_up();
  FrameSettings further = wanted_;
  if (pass_ + 1 < options_.passes && !is_animated_) {
    further.pass = pass_ + 1;
  } else if (!options_.never_rests && !is_animated_) {
    return std::nullopt;
  }
  return further;
}

// The best step that is expected to be done within the budget, else the least that shows more.
std::optional<FrameSettings> InteractiveLoop::step_up() const {
  std::optional<FrameSettings> least;
  std::optional<FrameSettings> best;
  const auto offer = [&](const FrameSettings& settings) {
    if (best_ && !FramePacer::is_better(settings, *best_)) return;
    if (!least) least = settings;
    if (pacer_.expected_seconds(settings) <= options_.budget_seconds) best = settings;
  };
  if (options_.budget_seconds > 0) {
    for (const double scale : kSteps) offer(pacer_.scaled(wanted_, scale));
    const FrameSettings all_pixels = pacer_.scaled(wanted_, 1);
    if (pacer_.expected_seconds(all_pixels) * kWorthStep <= pacer_.expected_seconds(wanted_))
      offer(all_pixels);
  }
  offer(wanted_);
  return best ? best : least;
}

void InteractiveLoop::submitted(FrameId frame, TimePoint now) {
  proposed_.frame = frame;
  proposed_.submitted = now;
  in_flight_.push_back(proposed_);
  if (proposed_.wish != wish_) return;  // another wish came in between
  best_ = proposed_.settings;
  pass_ = proposed_.settings.pass;
}

void InteractiveLoop::status_came(std::size_t slave_count, TimePoint now) {
  has_slaves_ = slave_count > 0;
  status_due_ = now + from_seconds(kStatusSeconds);
}

InteractiveLoop::Arrival InteractiveLoop::arrived(FrameId frame, bool is_finished,
                                                  double render_seconds, TimePoint now) {
  TESSERA_CHECK_EQ(in_flight_.empty(), false);
  TESSERA_CHECK_EQ(in_flight_.front().frame, frame);
  const InFlight came = in_flight_.front();
  in_flight_.pop_front();
  if (is_finished) {
    // The first frame has waited for the scene's way to the slaves and for its tree.
    pacer_.frame_done(came.settings, has_measured_ ? seconds(now - begun(came)) : render_seconds);
    has_measured_ = true;
  }
  last_arrival_ = now;
  Arrival arrival;
  arrival.is_left_behind = came.is_left_behind;
  arrival.pass = came.settings.pass;
  FrameSettings first_pass = came.settings;
  first_pass.pass = 0;
  arrival.is_full = first_pass == came.wanted;
  arrival.width_px = came.wanted.width_px;
  arrival.height_px = came.wanted.height_px;
  arrival.latency_seconds = seconds(now - came.submitted);
  return arrival;
}

double InteractiveLoop::wait_seconds(TimePoint now) const {
  TimePoint until = status_due_;
  if (moved_ && is_moving(now)) until = std::min(until, *moved_ + from_seconds(kRestSeconds));
  if (!best_ || is_animated_) {
    if (is_moving(now)) until = std::min(until, std::max(now, moving_due()));
  }
  // Looking after an overdue frame is as urgent as the budget.
  if (!in_flight_.empty() && options_.budget_seconds > 0)
    until = std::min(until, now + from_seconds(options_.budget_seconds));
  return std::max(kWaitSecondsMin, seconds(until - now));
}

}  // namespace tessera
