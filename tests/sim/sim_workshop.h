// SPDX-License-Identifier: Apache-2.0
// The workshop of a simulated slave: workers whose tiles take as long as a model says, and a
// builder; both in virtual time, with the queues and answers of the product's own
// (render_service.h, scene_builder.h). Scenes are built in earnest where the model says so.
//
// Threads. The simulation's one.
// Invariants. Those of slave/workshop.h.
#pragma once

#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>

#include "slave/slave_node.h"
#include "slave/tile_queue.h"
#include "tests/sim/process.h"

namespace tessera::sim {

struct WorkModel {
  int threads = 1;
  // Seconds that a tile takes here.
  std::function<double(const slave::FrameWork&, TileIndex)> tile_seconds;
  double build_seconds = 0.01;
  bool fails_builds = false;                          // as a slave with too little memory
  std::optional<core::BuildOptions> builds = {};      // scenes are built by the core, and met
  bool has_pixels = true;                             // false: black ones, where only time matters
  bool is_relaying = false;                           // feeds other slaves and is fed by them
  bool is_frozen_for_good = false;                    // no tile is ever finished
  std::function<void(TileIndex)> on_begin = {};       // a tile is begun; may be null
  std::function<void(wire::TileResult&)> alter = {};  // what is said of a tile; may be null
  // Sees each scene that is to be built; may be null.
  std::function<void(SceneVersion, const EncodedScene&)> on_scene;
};

class SimWorkshop final : public slave::Workshop {
 public:
  SimWorkshop(Process& process, WorkModel model);

  // Must be called before anything is pushed.
  void set_node(slave::SlaveNode* node) { node_ = node; }

  bool try_push(slave::TileJob job) override;
  void remove_frame(const slave::FrameWork* frame) override;
  std::deque<slave::TileJob> remove_all() override;
  void set_open_frames(std::size_t frames) override;
  // The render threads stand still; the network thread does not know.
  void set_frozen(bool is_frozen) { is_frozen_ = is_frozen; }
  bool try_push(slave::BuildTask task) override;
  void retire(std::uint64_t generation, SceneVersion first_kept) override;
  void forget_newest() override { preparation_.forget_newest(); }

  std::size_t queued_tiles() const { return jobs_.size(); }
  std::size_t working() const { return running_.size(); }
  double busy_seconds() const { return busy_seconds_; }
  double starved_seconds_total() const { return starved_total_; }

 private:
  struct Run {
    slave::TileJob job;
    TimePoint began;
  };
  using RunIterator = std::list<Run>::iterator;

  void start_work();
  void finish(RunIterator run);
  void drop_cancelled();
  void account_waiting();
  wire::TileResult render(const Run& run);
  void build_next();
  void stop_build_if_due();
  void end_build(bool was_stopped);
  Result<std::shared_ptr<const core::PreparedScene>> prepare(const slave::BuildTask& task);

  Process& process_;
  const WorkModel model_;
  slave::SlaveNode* node_ = nullptr;
  std::deque<slave::TileJob> jobs_;
  std::list<Run> running_;
  std::map<const Run*, std::uint64_t> run_ids_;  // of runs not finished
  std::uint64_t next_run_ = 0;
  slave::StarvationClock starvation_;
  double busy_seconds_ = 0, starved_total_ = 0;
  bool is_frozen_ = false;
  slave::BuildOrder builds_;
  slave::ScenePreparation preparation_;  // where scenes are built
  const slave::BuildTask* building_ = nullptr;
  std::uint64_t build_ = 0;  // number of the build, so that a stopped one does not end again
};

}  // namespace tessera::sim
