// SPDX-License-Identifier: Apache-2.0
// One process of the simulated world: the event loop that its protocol objects live on. It runs one
// task at a time, each of which may cost time; it may hang (as under SIGSTOP: tasks and timers
// wait) and end.
//
// Threads. The simulation's one.
// Invariants. (1) Nothing of a process runs after its end. (2) Tasks run in the order in which they
// became ready.
#pragma once

#include <deque>
#include <memory>
#include <string>

#include "common/net/event_loop.h"
#include "tests/sim/event_queue.h"

namespace tessera::sim {

class Process final : public net::EventLoop {
 public:
  // `node`: the machine it runs on, as the network numbers them.
  Process(EventQueue& queue, std::string name, int node);
  ~Process() override;  // ends

  // Event loop of the product's objects. A posted task runs after the current one, at the same
  // moment.
  void post(std::function<void()> task) override;
  void run_and_wait(std::function<void()> task) override { task(); }
  bool is_current() const override { return true; }
  std::unique_ptr<net::TimerBackend> make_timer() override;

  // Runs `task` at `time`, or when the process gets to it; the process is busy for `cost`
  // afterwards.
  void run_at(TimePoint time, Duration cost, std::function<void()> task);

  // Runs `task` now, or when the process gets to it. Requires: not called from within a task.
  void run_now(Duration cost, std::function<void()> task);

  void set_hung(bool is_hung);
  bool is_hung() const;
  void end();  // without a word; pending tasks are dropped
  bool is_alive() const;

  EventQueue& queue() const { return queue_; }
  const std::string& name() const { return name_; }
  int node() const { return node_; }
  std::uint64_t task_count() const;  // run so far
  double busy_seconds() const;       // of all costs so far

  // What the handling of each record that arrives costs (a model of the machine's speed).
  Duration record_cost{};

  struct Life;

 private:
  EventQueue& queue_;
  const std::string name_;
  const int node_;
  std::shared_ptr<Life> life_;
};

}  // namespace tessera::sim
