// SPDX-License-Identifier: Apache-2.0
// A cluster in virtual time, as the scheduler sees it: slaves with threads, tile times and round
// trips, and an application that keeps the frames coming. For tests of how good the scheduler is;
// tests/sim drives the whole product.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "master/schedule/scheduler.h"

namespace tessera::master {

struct WorldSlave {
  std::uint32_t threads = 1;
  double tile_seconds = 0.010;
  double round_trip_seconds = 0.0002;
  double hangs_at = 1e9;  // from then on the slave says nothing, and nobody notices
};

struct WorldResult {
  double seconds = 0;           // until the last frame
  double utilisation = 0;       // rendering time / thread time
  double worst_frame = 0;       // between two completions
  double duplicated_share = 0;  // of the tiles, leased again
  double compared_share = 0;    // of the tiles, rendered by another slave for an audit
  std::vector<std::uint64_t> tiles_by_slave;
};

class ScheduleWorld {
 public:
  ScheduleWorld(const SchedulerOptions& options, std::vector<WorldSlave> slaves, double spread = 0)
      : options_(options), scheduler_(options), spread_(spread) {
    for (const WorldSlave& slave : slaves) slaves_.push_back({slave, 0, {}, {}});
  }

  WorldResult run(int frames, TileIndex tiles_per_frame) {
    frames_ = frames;
    tiles_ = tiles_per_frame;
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      scheduler_.slave_joined(i + 1, {"s" + std::to_string(i + 1), "", 0}, slaves_[i].is.threads,
                              now());
      scheduler_.round_trip_measured(i + 1, slaves_[i].is.round_trip_seconds);
    }
    perform(scheduler_.start(now()));
    for (std::size_t i = 0; i < slaves_.size(); ++i)
      perform(scheduler_.scene_built(i + 1, 1, now()));
    for (int i = 0; i < options_.frames_in_flight; ++i) submit();
    at(kTick, [this] { tick(); });
    while (done_ < frames_ && !events_.empty() && time_ < 600) step();
    return result();
  }

 private:
  static constexpr double kTick = 0.010;
  struct Job {
    Action lease;
    double arrived = 0;
  };
  struct Slave {
    WorldSlave is;
    std::uint32_t busy = 0;
    std::deque<Job> queue;
    std::vector<double> idle_since;
    double rendered = 0;
    std::uint64_t tiles = 0;
    double starved = 0, looked = 0;
  };
  struct Event {
    double time = 0;
    std::uint64_t order = 0;
    std::function<void()> run;
    bool operator>(const Event& o) const {
      return std::pair(time, order) > std::pair(o.time, o.order);
    }
  };

  TimePoint now() const { return TimePoint{} + from_seconds(time_); }
  void at(double delay, std::function<void()> run) {
    events_.push({time_ + delay, order_++, std::move(run)});
  }
  void step() {
    const Event event = events_.top();
    events_.pop();
    time_ = event.time;
    event.run();
  }
  void tick() {
    perform(scheduler_.tick(now()));
    at(kTick, [this] { tick(); });
  }
  void submit() {
    if (submitted_ >= frames_) return;
    std::vector<TileIndex> order(tiles_);
    for (TileIndex i = 0; i < tiles_; ++i) order[i] = i;
    const FrameId frame = static_cast<FrameId>(submitted_++);
    perform(scheduler_.submit_frame(frame, 1, order, now()));
  }
  void perform(const Actions& actions) {
    for (const Action& action : actions) {
      if (action.kind == ActionKind::kLease) {
        (action.tile.is_comparison ? comparisons_ : leases_) += 1;
        Slave& slave = slaves_[action.session - 1];
        at(slave.is.round_trip_seconds / 2, [this, action] { arrive(action); });
      } else if (action.kind == ActionKind::kFrameComplete) {
        worst_ = std::max(worst_, time_ - last_done_);
        last_done_ = time_;
        ++done_;
        at(0, [this] { submit(); });
      }
    }
  }
  void look(Slave& slave) {
    if (done_ < frames_) slave.starved += (slave.is.threads - slave.busy) * (time_ - slave.looked);
    slave.looked = time_;
  }
  void arrive(const Action& lease) {
    Slave& slave = slaves_[lease.session - 1];
    look(slave);
    auto place = slave.queue.end();
    while (place != slave.queue.begin() && lease.frame < std::prev(place)->lease.frame) --place;
    slave.queue.insert(place, {lease, time_});
    start(slave);
  }
  void start(Slave& slave) {
    while (slave.busy < slave.is.threads && !slave.queue.empty() && time_ < slave.is.hangs_at) {
      const Job job = slave.queue.front();
      slave.queue.pop_front();
      ++slave.busy;
      const double took = slave.is.tile_seconds *
                          (1 + spread_ * std::uniform_real_distribution<double>(-1, 1)(random_));
      at(took, [this, &slave, job, took] { finish(slave, job, took); });
    }
  }
  void finish(Slave& slave, const Job& job, double took) {
    look(slave);
    --slave.busy;
    slave.rendered += took;
    ++slave.tiles;
    if (time_ < slave.is.hangs_at) {
      const double starved = std::exchange(slave.starved, 0);
      const double held = time_ - job.arrived;
      at(slave.is.round_trip_seconds / 2, [this, lease = job.lease, took, held, starved] {
        Actions actions;
        scheduler_.result(
            lease.session,
            {lease.frame, 1, lease.tile.tile, lease.tile.attempt, took, held, starved, 0}, now(),
            actions);
        perform(actions);
      });
    }
    start(slave);
  }
  WorldResult result() const {
    WorldResult r;
    r.seconds = done_ == frames_ ? last_done_ : 1e9;
    double rendered = 0, threads = 0;
    for (const Slave& slave : slaves_) {
      rendered += slave.rendered;
      threads += slave.is.threads;
      r.tiles_by_slave.push_back(slave.tiles);
    }
    r.utilisation = rendered / (threads * last_done_);
    r.worst_frame = worst_;
    r.duplicated_share = leases_ / (static_cast<double>(frames_) * tiles_) - 1;
    r.compared_share = comparisons_ / (static_cast<double>(frames_) * tiles_);
    return r;
  }

  const SchedulerOptions options_;
  Scheduler scheduler_;
  const double spread_;
  std::mt19937_64 random_{1};
  std::deque<Slave> slaves_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t order_ = 0;
  double time_ = 0, last_done_ = 0, worst_ = 0, leases_ = 0, comparisons_ = 0;
  int frames_ = 0, submitted_ = 0, done_ = 0;
  TileIndex tiles_ = 0;
};

}  // namespace tessera::master
