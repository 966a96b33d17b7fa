// SPDX-License-Identifier: Apache-2.0
// What must hold in every moment of a storm: the invariants of the fault matrix, as far as a
// simulation can see them. The oracle knows what has been done to whom, and for how long that
// excuses them.
//
//   I1-I3  each picture is its own, in order, once: SimApp looks
//   I4     send queues, tiles on a slave, connections and planned events stay within their bounds
//   I5     a process that waits does next to nothing (after the last frame)
//   I6     frames come on, and none fails, while one healthy slave is there; the dead are found in
//          time, by master and slave alike, the healthy are never taken for dead and come back in
//          time
//   I7     every lease has one end, and the master's account is that of the wire; nobody is accused
//          of a breach of protocol, no lie counts as a tile, no two slaves have one name, no honest
//          slave is held back; who has stalled and returns a tile has stalled no more
//
// Threads. One.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/sim/endings.h"
#include "tests/sim/scene_watch.h"
#include "tests/sim/sim_app.h"
#include "tests/sim/sim_master.h"
#include "tests/sim/sim_slave.h"
#include "tests/sim/storm_plan.h"

namespace tessera::sim {

class Oracle {
 public:
  struct World {
    EventQueue& queue;
    Network& network;
    SimMaster& master;
    SimApp& app;
    std::vector<std::unique_ptr<SimSlave>>& slaves;
  };

  Oracle(const StormPlan& plan, const World& world);

  // A fault of one slave, or of all, begins or ends. Until `until_seconds` it excuses them.
  void trouble_slave(std::size_t slave, double until_seconds);
  void trouble_all(double until_seconds);
  // is_gone: the slave stopped answering at this moment; false: it has come back.
  void set_gone(std::size_t slave, bool is_gone);
  // Until then another slave may stand in the master's list under this one's name.
  void take_name(std::size_t slave, double until_seconds);

  void on_sent(const Process& from, int to_node, const net::Record& record);
  void on_queued(const Process& from, int to_node, std::uint64_t queue_bytes);
  void on_outcome(FrameId frame, const Status& status);
  void on_master_started() {
    leases_sent_ = 0;
    endings_.on_master_started();
  }
  void on_bad_end(const std::string& slave, bool has_brought) {
    endings_.on_bad_end(slave, has_brought);
  }
  void report(const std::string& violation);

  SceneWatch& scenes() { return scenes_; }

  void check();  // after every event
  bool are_all_back() const;
  void check_idle();  // when all is over and quiet

  const std::string& violation() const { return violation_; }
  double bound_of_progress() const { return progress_bound_; }
  // Seconds after which everything that was healed works again.
  double bound_of_return() const { return return_bound_; }

 private:
  struct Watch {
    double troubled_until = 0;  // whatever happens to it until then has an excuse
    double gone_since = -1;     // < 0: it is there
    double name_taken_until = 0;
    double stalled_since = -1, last_result = -1;  // < 0: it has not stalled; it has sent none
    bool was_listed = false;
    double listed_since = 0;
    double hung_at = 0;  // last seen hanging then
  };

  void check_refusal(const Process& from, const net::Record& record);
  void check_silence();
  void check_accounts(const ClusterStatus& status);
  void check_slaves(const ClusterStatus& status);
  void check_bad_slave(const SlaveStatus& slave);
  void check_stall(std::size_t index, const SlaveStatus& slave);
  void check_progress(const ClusterStatus& status);
  double detection_bound(std::size_t slave) const;
  std::uint64_t queue_bound(const Process& from, int to_node) const;
  std::optional<std::size_t> slave_at(int node) const;
  bool is_healthy(std::size_t slave) const;

  const StormPlan& plan_;
  World world_;
  std::vector<Watch> watches_;
  std::map<std::string, std::size_t> by_name_;
  double all_troubled_until_ = 0, last_progress_ = 0;
  double progress_bound_ = 0, return_bound_ = 0;
  double silence_looked_ = 0, master_hung_at_ = 0;
  std::uint64_t leases_sent_ = 0;
  std::uint64_t master_tasks_seen_ = 0;
  const Process* master_seen_ = nullptr;
  std::string violation_;
  Endings endings_;
  SceneWatch scenes_;
};

}  // namespace tessera::sim
