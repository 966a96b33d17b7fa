// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/bad_slaves.h"

#include <utility>

namespace tessera::sim {
namespace {

// As a service manager that starts a service again at once.
constexpr std::chrono::milliseconds kRestart{100};
// How long a process of a liar lives: whoever is held back for lies comes as another one.
constexpr std::chrono::milliseconds kLiarLife{1500};
// How long one of a forger lives: whoever leaves in order is held back for nothing.
constexpr std::chrono::milliseconds kForgerLives[] = {
    std::chrono::milliseconds(100), std::chrono::milliseconds(200), std::chrono::milliseconds(400),
    std::chrono::milliseconds(800)};
constexpr std::chrono::milliseconds kForgerLook{20};

// Each of these answers no lease of the slave's.
void lie(wire::TileResult& result, int variant) {
  switch (variant % 4) {
    case 0:
      result.pixels.pop_back();
      break;
    case 1:
      result.tile += 1000;
      break;
    case 2:
      ++result.version;
      break;
    default:
      result.attempt += 100;
      break;
  }
}

}  // namespace

BadSlaves::BadSlaves(EventQueue& queue, Network& network, int master_node, const StormPlan& plan)
    : queue_(queue), plan_(plan) {
  for (std::size_t i = 0; i < plan.bad_slaves.size(); ++i) {
    const BadSlavePlan& bad = plan.bad_slaves[i];
    const bool is_taker = bad.vice == Vice::kTakesName;
    const std::string name = is_taker ? "s" + std::to_string(bad.victim) : name_of_bad_slave(i);
    const int node = network.add_node(bad.slave.link);
    all_.push_back(
        {bad, std::make_unique<SimSlave>(queue, network, name, node, master_node, model_of(i))});
  }
}

BadSlaves::~BadSlaves() { end(); }

WorkModel BadSlaves::model_of(std::size_t index) {
  const BadSlavePlan& bad = plan_.bad_slaves[index];
  WorkModel model;
  model.threads = bad.slave.threads;
  model.build_seconds = bad.slave.build_seconds;
  model.tile_seconds = [seconds = bad.slave.tile_seconds](const slave::FrameWork&, TileIndex) {
    return seconds;
  };
  if (bad.vice == Vice::kDies) {
    model.on_begin = [this, index](TileIndex tile) { on_begin(index, tile); };
    model.alter = [this, index](wire::TileResult&) { ++all_[index].brought; };
  }
  if (bad.vice == Vice::kLies)
    model.alter = [variant = bad.variant](wire::TileResult& result) { lie(result, variant); };
  if (bad.vice == Vice::kForges) {
    model.alter = [](wire::TileResult& result) {
      for (std::byte& byte : result.pixels) byte ^= std::byte{1};
    };
  }
  model.is_frozen_for_good = bad.vice == Vice::kHoards;
  return model;
}

void BadSlaves::start(Oracle& oracle, double until_seconds) {
  oracle_ = &oracle;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const BadSlavePlan& bad = all_[i].plan;
    if (bad.vice == Vice::kTakesName)
      oracle.take_name(static_cast<std::size_t>(bad.victim), until_seconds);
    queue_.after(from_seconds(bad.slave.joins_at), [this, i] { begin_life(i); });
  }
}

void BadSlaves::begin_life(std::size_t index) {
  if (is_over_) return;
  all_[index].is_dying = false;
  all_[index].begun = all_[index].brought = 0;
  all_[index].slave->start();
  if (all_[index].plan.vice == Vice::kLies)
    queue_.after(kLiarLife, [this, index] { start_anew(index); });
  if (all_[index].plan.vice == Vice::kForges)
    queue_.after(kForgerLives[all_[index].plan.variant], [this, index] { go_and_return(index); });
}

// The slave leaves in order, which takes a while, and is there again.
void BadSlaves::go_and_return(std::size_t index) {
  if (is_over_) return;
  SimSlave& slave = *all_[index].slave;
  if (!slave.is_running()) return begin_life(index);
  slave.leave();
  queue_.after(kForgerLook, [this, index] { go_and_return(index); });
}

void BadSlaves::start_anew(std::size_t index) {
  if (is_over_) return;
  all_[index].slave->kill(false);
  begin_life(index);
}

// Some bring a few tiles first: whoever brings as many as it takes with it is not held back.
void BadSlaves::on_begin(std::size_t index, TileIndex tile) {
  constexpr int kLastTile[] = {1, 1, 4, 12};
  One& one = all_[index];
  ++one.begun;
  const bool is_last = one.plan.is_one_tile_fatal ? tile == one.plan.fatal_tile
                                                  : one.begun >= kLastTile[one.plan.variant];
  if (is_last) die(index);
}

// The process ends by an event, since the task that begins the tile is its own.
void BadSlaves::die(std::size_t index) {
  if (std::exchange(all_[index].is_dying, true)) return;
  oracle_->on_bad_end(all_[index].slave->name(), all_[index].brought > 0);
  queue_.after(Duration::zero(), [this, index] { all_[index].slave->kill(false); });
  queue_.after(kRestart, [this, index] { begin_life(index); });
}

void BadSlaves::end() {
  is_over_ = true;
  for (One& one : all_) one.slave->kill(false);
}

}  // namespace tessera::sim
