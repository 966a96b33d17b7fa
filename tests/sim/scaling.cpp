// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/scaling.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "common/base/check.h"
#include "tests/sim/picture.h"
#include "tests/sim/sim_master.h"
#include "tests/sim/sim_slave.h"

namespace tessera::sim {
namespace {

constexpr int kWarmUpFrames = 4;
constexpr double kBusyShare = 0.9;  // a resource that is busier than this holds the others up

class Cluster {
 public:
  explicit Cluster(const ScalingCase& scaling);
  ~Cluster();
  ScalingResult run();

 private:
  void submit();
  double cost_of(const slave::FrameWork& work, TileIndex tile) const;
  double busy_seconds() const;

  const ScalingCase& case_;
  EventQueue queue_{1};
  Network network_{queue_, 1};
  std::unique_ptr<SimMaster> master_;
  std::vector<std::unique_ptr<SimSlave>> slaves_;
  FrameId next_frame_ = 0;
  int finished_ = 0;
  int tile_edge_px_ = 0;
};

Cluster::Cluster(const ScalingCase& scaling) : case_(scaling) {
  LinkModel link;
  link.up_bytes_per_s = link.down_bytes_per_s = scaling.master_bytes_per_s;
  const int node = network_.add_node(link);
  master::FrameLoopOptions options;
  options.frames_in_flight = scaling.frames_in_flight;
  options.prefetch_per_thread = scaling.prefetch_per_thread;
  options.slaves_min = scaling.slaves;
  master_ = std::make_unique<SimMaster>(queue_, network_, node, options,
                                        from_seconds(scaling.master_record_seconds));
  link.up_bytes_per_s = link.down_bytes_per_s = scaling.slave_bytes_per_s;
  link.delay = from_seconds(scaling.delay_seconds);
  for (int i = 0; i < scaling.slaves; ++i) {
    WorkModel model;
    model.threads = scaling.threads;
    model.has_pixels = false;
    model.tile_seconds = [this](const slave::FrameWork& work, TileIndex tile) {
      return cost_of(work, tile);
    };
    slaves_.push_back(std::make_unique<SimSlave>(queue_, network_, "s" + std::to_string(i),
                                                 network_.add_node(link), node, std::move(model)));
  }
}

Cluster::~Cluster() {
  for (const auto& slave : slaves_) slave->kill(true);
  master_->kill(true);
}

// Expensive regions drift over the picture as the camera moves; each tile has a share of its own,
// too.
double Cluster::cost_of(const slave::FrameWork& work, TileIndex tile) const {
  const FrameId frame = work.begin.frame;
  if (case_.costs) {
    return case_.cost_scale *
           case_.costs->tile_seconds(frame, work.grid.rect(tile), case_.width_px, case_.height_px);
  }
  const int columns = work.grid.columns();
  const double x = static_cast<double>(static_cast<int>(tile) % columns) / columns;
  const double y = static_cast<double>(static_cast<int>(tile) / columns) / columns;
  const double wave =
      std::sin(6.283 * (x + 0.02 * static_cast<double>(frame))) * std::cos(6.283 * y);
  const double own = 2 * static_cast<double>(mix(frame << 32 ^ tile) >> 11) * 0x1p-53 - 1;
  return case_.tile_seconds * (1 + case_.tile_spread * (0.6 * wave + 0.4 * own));
}

void Cluster::submit() {
  FrameSettings settings;
  settings.width_px = case_.width_px;
  settings.height_px = case_.height_px;
  settings.tile_edge_px = case_.tile_edge_px;
  settings.pixel_format = PixelFormat::kDisplay8;
  master_->loop().submit(next_frame_++, 1, settings);
}

double Cluster::busy_seconds() const {
  double sum = 0;
  for (const auto& slave : slaves_) sum += slave->workshop()->busy_seconds();
  return sum;
}

ScalingResult Cluster::run() {
  master_->start();
  for (const auto& slave : slaves_) slave->start();
  const int warm_up = kWarmUpFrames, total = warm_up + case_.frames;
  double begin = 0, begin_busy = 0, begin_cpu = 0;
  std::uint64_t begin_bytes = 0;
  const auto bytes = [this] {
    std::uint64_t sum = 0;
    for (const auto& slave : slaves_) sum += network_.bytes_between(slave->node(), master_->node());
    return sum;
  };
  master_->process()->post([&] {
    master_->loop().set_outcome_callback([&](const master::FrameOutcome& outcome) {
      TESSERA_CHECK(outcome.status.is_ok());
      tile_edge_px_ = static_cast<int>(outcome.stats.tile_edge_px);
      if (++finished_ == warm_up) {
        begin = queue_.now_seconds();
        begin_busy = busy_seconds();
        begin_cpu = master_->process()->busy_seconds();
        begin_bytes = bytes();
      }
      master_->process()->post([this] { submit(); });
    });
    master_->loop().commit_scene(1, scene_of_tag(1, SceneWeight::kLight));
    for (int i = 0; i < case_.frames_in_flight; ++i) submit();
  });
  while (finished_ < total) TESSERA_CHECK(queue_.step());
  master_->loop().set_outcome_callback({});  // the frames in work are cancelled at the end
  const double time = queue_.now_seconds() - begin;
  ScalingResult result;
  const auto received = static_cast<double>(bytes() - begin_bytes);
  result.frames_per_s = case_.frames / time;
  result.utilisation = (busy_seconds() - begin_busy) / (time * case_.slaves * case_.threads);
  result.master_cpu_share = (master_->process()->busy_seconds() - begin_cpu) / time;
  result.bytes_per_frame = received / case_.frames;
  if (case_.master_bytes_per_s > 0) result.wire_share = received / time / case_.master_bytes_per_s;
  result.tile_edge_px = tile_edge_px_;
  result.events = queue_.event_count();
  return result;
}

}  // namespace

std::string ScalingResult::limit() const {
  if (wire_share > kBusyShare) return "wire";
  if (master_cpu_share > kBusyShare) return "master CPU";
  return utilisation > kBusyShare ? "slaves" : "tail";
}

ScalingResult run_scaling(const ScalingCase& scaling) {
  Cluster cluster(scaling);
  return cluster.run();
}

}  // namespace tessera::sim
