// SPDX-License-Identifier: Apache-2.0
// Whatever a stranger says to a slave in the place of its master: once an honest master is there,
// the slave joins it and renders its frame.
#include <cstdlib>
#include <optional>

#include "tests/fuzz/peers/stranger.h"
#include "tests/sim/picture.h"
#include "tests/sim/sim_master.h"
#include "tests/sim/sim_slave.h"

namespace {

using namespace tessera;

constexpr double kPatienceSeconds = 400;  // of virtual time

class World {
 public:
  explicit World(bool is_relaying)
      : master_node_(network_.add_node({})),
        slave_(queue_, network_, "s0", network_.add_node({}), master_node_, work(is_relaying)),
        stranger_(std::in_place, queue_, network_, master_node_) {
    stranger_->listen();
    stranger_->heard.host = sim::Network::host_of(slave_.node());
    slave_.start();
    test::run_for(queue_, std::chrono::milliseconds(10));
  }
  ~World() {
    stranger_.reset();
    slave_.kill(true);
  }

  void step(test::FuzzInput& input) {
    stranger_->step(input, slave_.node(), [&](std::uint8_t kind) {
      if (kind == 0) return slave_.set_frozen(input.yes());
      test::run_for(queue_, std::chrono::milliseconds(kind));
    });
  }

  void end() {
    stranger_.reset();
    slave_.set_frozen(false);
    sim::SimMaster master(queue_, network_, master_node_, {}, {});
    master.start();
    std::optional<Status> outcome;
    master.loop().set_outcome_callback(
        [&](const master::FrameOutcome& ended) { outcome = ended.status; });
    master.loop().commit_scene(1, sim::scene_of_tag(1, sim::SceneWeight::kLight));
    FrameSettings settings;
    settings.width_px = settings.height_px = 32;
    settings.pixel_format = PixelFormat::kDisplay8;
    master.loop().submit(1, 1, settings);
    const bool is_over =
        test::run_until(queue_, kPatienceSeconds, [&] { return outcome.has_value(); });
    slave_.kill(true);
    master.kill(true);
    if (!is_over || !outcome->is_ok()) std::abort();
  }

 private:
  static sim::WorkModel work(bool is_relaying) {
    sim::WorkModel model;
    model.threads = 2;
    model.is_relaying = is_relaying;
    model.has_pixels = false;
    model.tile_seconds = [](const slave::FrameWork&, TileIndex) { return 0.02; };
    return model;
  }

  sim::EventQueue queue_{1};
  sim::Network network_{queue_, 1};
  const int master_node_;
  sim::SimSlave slave_;
  std::optional<test::Stranger> stranger_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  test::silence_log();
  test::FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  World world((kind & 1) != 0);
  for (int i = 0; i < test::Stranger::kStepsMax && !input.is_at_end(); ++i) world.step(input);
  world.end();
  return 0;
}
