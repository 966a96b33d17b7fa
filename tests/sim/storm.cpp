// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/storm.h"

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "common/wire/codec.h"
#include "tests/sim/bad_slaves.h"
#include "tests/sim/faults.h"
#include "tests/sim/oracle.h"
#include "tests/sim/watchers.h"

namespace tessera::sim {
namespace {

constexpr double kIdleSeconds = 3;           // watched after the last frame
constexpr double kIdleTasksPerSecond = 400;  // of one process: timers and heartbeats
constexpr double kEndSeconds = 400;
constexpr double kWatchedSeconds = 6;  // status clients come and go for so long at least
constexpr std::uint64_t kEventsMax = 8'000'000;

class Storm {
 public:
  Storm(const StormPlan& plan, bool has_trace);
  ~Storm();
  StormReport run();

 private:
  void build_slaves();
  void plan_fault(const Fault& fault);
  void calm();  // everything heals
  void supervise();
  bool is_finished();
  void trace(const std::string& line);
  void trace_record(const Process& from, int to_node, const net::Record& record);

  const StormPlan& plan_;
  const bool has_trace_;
  EventQueue queue_;
  Network network_;
  std::unique_ptr<SimMaster> master_;
  std::vector<std::unique_ptr<SimSlave>> slaves_;
  std::unique_ptr<BadSlaves> bad_slaves_;
  std::unique_ptr<Watchers> watchers_;
  std::unique_ptr<SimApp> app_;
  std::unique_ptr<Oracle> oracle_;
  std::unique_ptr<Faults> faults_;
  double calm_at_ = 0;
  bool is_calm_ = false;
  double idle_since_ = -1;
  std::vector<std::uint64_t> idle_tasks_;
  int frames_failed_ = 0;
  double first_frame_at_ = -1, last_frame_at_ = -1;
};

Storm::Storm(const StormPlan& plan, bool has_trace)
    : plan_(plan), has_trace_(has_trace), queue_(plan.seed), network_(queue_, mix(plan.seed + 1)) {
  const int master_node = network_.add_node(plan.master_link);
  master::FrameLoopOptions options;
  options.frames_in_flight = plan.frames_in_flight;
  options.slaves_min = plan.slaves_min;
  options.serves_applications = true;
  options.audit.share = plan.audit_share;
  master_ = std::make_unique<SimMaster>(queue_, network_, master_node, options,
                                        from_seconds(plan.master_record_seconds));
  build_slaves();
  LinkModel near;
  near.delay = std::chrono::microseconds(50);
  const int app_node = network_.add_node(near);
  SimApp::Events events;
  events.on_outcome = [this](FrameId frame, const Status& status) {
    oracle_->on_outcome(frame, status);
    frames_failed_ += status.is_ok() ? 0 : 1;
    if (first_frame_at_ < 0) first_frame_at_ = queue_.now_seconds();
    last_frame_at_ = queue_.now_seconds();
    if (has_trace_) {
      trace("frame " + std::to_string(frame) +
            (status.is_ok() ? " is here" : ": " + status.message()));
    }
    const bool is_excused = status.is_ok() || status.code() == StatusCode::kCancelled || !is_calm_;
    if (!is_excused && queue_.now_seconds() > calm_at_ + oracle_->bound_of_return()) {
      oracle_->report("I2: a frame failed on a calm day: " + status.message());
    }
  };
  bad_slaves_ = std::make_unique<BadSlaves>(queue_, network_, master_node, plan_);
  watchers_ =
      std::make_unique<Watchers>(queue_, network_, master_node, plan.watchers, mix(plan.seed + 3));
  events.on_violation = [this](const std::string& what) { oracle_->report(what); };
  app_ = std::make_unique<SimApp>(queue_, network_, app_node, master_node, plan.script,
                                  mix(plan.seed + 2), std::move(events));
  oracle_ =
      std::make_unique<Oracle>(plan_, Oracle::World{queue_, network_, *master_, *app_, slaves_});
  faults_ =
      std::make_unique<Faults>(plan_, Faults::World{network_, *master_, *app_, slaves_, *oracle_});
  network_.events.on_sent = [this](const Process& from, int to, const net::Record& record) {
    oracle_->on_sent(from, to, record);
    if (has_trace_) trace_record(from, to, record);
  };
  network_.events.on_queued = [this](const Process& from, int to, std::uint64_t bytes) {
    oracle_->on_queued(from, to, bytes);
  };
}

// Slaves and application end before the master, the network and the queue that they use.
Storm::~Storm() {
  app_->kill(true);
  watchers_->end();
  bad_slaves_->end();
  for (const auto& slave : slaves_) slave->kill(true);
  master_->kill(true);
}

void Storm::build_slaves() {
  for (std::size_t i = 0; i < plan_.slaves.size(); ++i) {
    const SlavePlan& slave = plan_.slaves[i];
    WorkModel model;
    model.threads = slave.threads;
    model.build_seconds = slave.build_seconds;
    model.fails_builds = slave.fails_builds;
    model.is_relaying = plan_.is_relaying;
    if (plan_.script.weight == SceneWeight::kEdited) {
      model.builds.emplace();
      model.builds->is_on_demand = slave.is_on_demand;
    }
    model.on_scene = [this, i](SceneVersion version, const EncodedScene& scene) {
      oracle_->scenes().on_scene(i, version, scene);
    };
    model.tile_seconds = [slave, seed = plan_.seed](const slave::FrameWork& work, TileIndex tile) {
      const double unit =
          static_cast<double>(mix(seed ^ work.begin.frame << 20 ^ tile) >> 11) * 0x1p-53;
      return slave.tile_seconds * (1 + slave.tile_spread * (2 * unit - 1));
    };
    const int node = network_.add_node(slave.link);
    slaves_.push_back(std::make_unique<SimSlave>(queue_, network_, "s" + std::to_string(i), node,
                                                 master_->node(), std::move(model)));
  }
}

void Storm::trace(const std::string& line) {
  if (has_trace_) std::printf("%10.6f %s\n", queue_.now_seconds(), line.c_str());
}

void Storm::trace_record(const Process& from, int to_node, const net::Record& record) {
  const auto message = wire::decode(
      {record.type, record.header,
       std::vector<std::byte>(record.payload.bytes.begin(), record.payload.bytes.end())});
  const std::string name =
      message.is_ok() ? wire::message_name(*message) : "record " + std::to_string(record.type);
  std::string detail;
  if (message.is_ok()) {
    if (const auto* lease = std::get_if<wire::TileLease>(&*message)) {
      detail = " frame " + std::to_string(lease->frame) + " tile " + std::to_string(lease->tile) +
               " attempt " + std::to_string(lease->attempt);
    } else if (const auto* result = std::get_if<wire::TileResult>(&*message)) {
      detail = " frame " + std::to_string(result->frame) + " tile " + std::to_string(result->tile) +
               " attempt " + std::to_string(result->attempt);
    } else if (const auto* announce = std::get_if<wire::SceneAnnounce>(&*message)) {
      detail = " version " + std::to_string(announce->version);
    } else if (const auto* retire = std::get_if<wire::SceneRetire>(&*message)) {
      detail = " before version " + std::to_string(retire->first_kept);
    } else if (const auto* built = std::get_if<wire::SceneBuilt>(&*message)) {
      detail = " version " + std::to_string(built->version);
    }
  }
  const std::string to = to_node == master_->node() ? "master"
                         : to_node == app_->node()  ? "app"
                                                    : "s" + std::to_string(to_node - 1);
  trace(from.name() + " -> " + to + " " + name + detail);
}

void Storm::plan_fault(const Fault& fault) {
  queue_.after(from_seconds(fault.at), [this, &fault] {
    trace(std::string("FAULT ") + fault_name(fault.kind) + " s" + std::to_string(fault.slave));
    faults_->begin(fault);
  });
  if (fault.is_for_good) return;
  queue_.after(from_seconds(fault.at + fault.duration), [this, &fault] {
    trace(std::string("over: ") + fault_name(fault.kind) + " s" + std::to_string(fault.slave));
    faults_->end(fault);
  });
  calm_at_ = std::max(calm_at_, fault.at + fault.duration + 0.001);
}

// Ends all faults that last, but for those between slaves, which excuse nobody; from now on nothing
// has an excuse for long.
void Storm::calm() {
  is_calm_ = true;
  trace("CALM");
  app_->set_ending();
  watchers_->end();
  bad_slaves_->end();
  network_.heal_all();
  network_.set_refusing(master_->node(), false);
  if (!master_->is_running()) {
    master_->start();
    oracle_->on_master_started();
  }
  master_->set_hung(false);
  app_->start();
  app_->set_hung(false);
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    oracle_->set_gone(i, false);
    slaves_[i]->set_hung(false);
    slaves_[i]->set_frozen(false);
    slaves_[i]->set_altering(false);
    network_.link(slaves_[i]->node()) = plan_.slaves[i].link;
    if (!slaves_[i]->is_running()) slaves_[i]->start();
    oracle_->trouble_slave(i, queue_.now_seconds() + oracle_->bound_of_return());
  }
  for (const Fault& fault : plan_.faults) {
    if (fault.is_for_good) faults_->begin(fault);
  }
}

// Acts as a service manager: when the storm is over, a slave that is not there is started.
void Storm::supervise() {
  queue_.after(std::chrono::seconds(1), [this] { supervise(); });
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    SimSlave& slave = *slaves_[i];
    if (!is_calm_ || slave.is_running()) continue;
    oracle_->trouble_slave(i, queue_.now_seconds() + oracle_->bound_of_return());
    slave.start();
  }
}

// Whether all frames have come, the storm is over, and nothing happened for a while after it.
bool Storm::is_finished() {
  if (!is_calm_ || (idle_since_ < 0 && !app_->is_done())) return false;
  const double now = queue_.now_seconds();
  if (idle_since_ < 0) {
    const bool is_time_up = now > calm_at_ + oracle_->bound_of_return() + 1;
    if (!oracle_->are_all_back() && !is_time_up) return false;
    if (oracle_->scenes().is_any_awaited()) return false;  // it comes, or is missed in time
    idle_since_ = now;
    app_->kill(false);
    return false;
  }
  if (idle_tasks_.empty() && now > idle_since_ + 1) {
    idle_tasks_.push_back(master_->process()->task_count());
    for (const auto& slave : slaves_)
      idle_tasks_.push_back(slave->process() ? slave->process()->task_count() : 0);
  }
  if (now < idle_since_ + 1 + kIdleSeconds) return false;
  const auto check = [this](const Process* process, std::uint64_t before) {
    if (process == nullptr || process->task_count() < before) return;
    const double rate = static_cast<double>(process->task_count() - before) / kIdleSeconds;
    if (rate > kIdleTasksPerSecond) {
      oracle_->report("I5: " + process->name() + " runs " + std::to_string(rate) +
                      " tasks a second with nothing to do");
    }
  };
  check(master_->process(), idle_tasks_[0]);
  for (std::size_t i = 0; i < slaves_.size(); ++i) check(slaves_[i]->process(), idle_tasks_[i + 1]);
  oracle_->check_idle();
  return true;
}

StormReport Storm::run() {
  master_->start();
  app_->start();
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    queue_.after(from_seconds(plan_.slaves[i].joins_at), [this, i] {
      if (slaves_[i]->is_running()) return;
      oracle_->set_gone(i, false);  // the slave may have lost its power before it joins
      slaves_[i]->start();
    });
    calm_at_ = std::max(calm_at_, plan_.slaves[i].joins_at + 0.001);
  }
  for (const Fault& fault : plan_.faults) plan_fault(fault);
  for (const BadSlavePlan& bad : plan_.bad_slaves) {
    // A slave that is waited for must stay until that is noticed, in some storms.
    const bool is_long = bad.vice == Vice::kHoards && bad.variant == 0;
    const double longer = is_long ? oracle_->bound_of_progress() : 0;
    const double stay = bad.is_one_tile_fatal ? kFatalTilesStay : kBadSlavesStay;
    const double until = std::max(kBadSlavesUntil, bad.slave.joins_at + stay);
    calm_at_ = std::max(calm_at_, until + longer);
  }
  if (plan_.watchers > 0) calm_at_ = std::max(calm_at_, kWatchedSeconds);
  bad_slaves_->start(*oracle_, calm_at_);
  watchers_->start();
  queue_.after(from_seconds(calm_at_), [this] { calm(); });
  supervise();
  while (oracle_->violation().empty() && !is_finished()) {
    if (!queue_.step()) break;
    oracle_->check();
    if (queue_.event_count() > kEventsMax || queue_.now_seconds() > kEndSeconds) {
      oracle_->report("I6: it does not come to an end: " + std::to_string(app_->delivered()) +
                      " frames delivered");
    }
  }
  StormReport report;
  report.violation = oracle_->violation();
  report.at_seconds = queue_.now_seconds();
  report.hash = queue_.hash();
  report.events = queue_.event_count();
  report.chunks_relayed = oracle_->scenes().chunks_relayed();
  report.frames_delivered = app_->delivered();
  report.frames_failed = frames_failed_;
  report.frames_seconds = last_frame_at_ - first_frame_at_;
  for (const auto& slave : slaves_)
    report.rendering.push_back(slave->workshop() ? slave->workshop()->busy_seconds() : 0);
  report.status_answers = watchers_->answers();
  return report;
}

}  // namespace

StormReport run_storm(const StormPlan& plan, bool has_trace) {
  Storm storm(plan, has_trace);
  return storm.run();
}

}  // namespace tessera::sim
