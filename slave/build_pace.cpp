// SPDX-License-Identifier: Apache-2.0
#include "slave/build_pace.h"

#include <algorithm>

namespace tessera::slave {

namespace {

// A thread that waits for others to stop is told of it; that it asks again is for safety.
constexpr Duration kLongest = std::chrono::milliseconds(100);

}  // namespace

BuildPace::BuildPace(int processors, double share) : processors_(processors), share_(share) {}

void BuildPace::set_rendering(int threads, TimePoint now) {
  account(now);
  rendering_ = std::clamp(threads, 0, processors_);
}

void BuildPace::enter(TimePoint now) {
  account(now);
  ++running_;
}

void BuildPace::leave(TimePoint now) {
  account(now);
  --running_;
}

bool BuildPace::goes_on(TimePoint now) {
  account(now);
  if (running_ <= free() || credit_seconds_ > 0) return true;
  --running_;
  return false;
}

bool BuildPace::resumes(TimePoint now) {
  account(now);
  const bool is_free = running_ < free();
  const bool is_its_turn =
      credit_seconds_ >= seconds(kTurn) && running_ < std::max(0, free()) + beyond_max();
  if (!is_free && !is_its_turn) return false;
  ++running_;
  return true;
}

TimePoint BuildPace::next_turn(TimePoint now) const {
  const double missing = seconds(kTurn) - credit_seconds_;
  if (missing <= 0 || refill() <= 0) return now + kLongest;
  const auto wait =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(missing / refill()));
  return now + std::clamp(wait, Duration(kTurn), kLongest);
}

void BuildPace::account(TimePoint now) {
  if (now <= marked_) return;
  const double passed = marked_ == TimePoint{} ? 0 : seconds(now - marked_);
  marked_ = now;
  const int beyond = std::max(0, running_ - free());
  credit_seconds_ =
      std::min(credit_seconds_ + passed * (refill() - beyond), beyond_max() * seconds(kTurn));
}

}  // namespace tessera::slave
