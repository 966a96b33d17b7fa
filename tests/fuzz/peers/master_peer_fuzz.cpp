// SPDX-License-Identifier: Apache-2.0
// Whatever strangers say to a master, as slaves, applications or status clients, in whatever order:
// once they are gone, all of its frames have ended, and an honest application and slave get theirs.
#include <cstdlib>
#include <optional>
#include <set>

#include "tests/fuzz/peers/stranger.h"
#include "tests/sim/picture.h"
#include "tests/sim/sim_app.h"
#include "tests/sim/sim_master.h"
#include "tests/sim/sim_slave.h"

namespace {

using namespace tessera;

constexpr std::uint64_t kRoomBytes = std::uint64_t{64} << 20;
constexpr double kPatienceSeconds = 400;  // of virtual time

sim::WorkModel honest_work() {
  sim::WorkModel model;
  model.tile_seconds = [](const slave::FrameWork&, TileIndex) { return 0.01; };
  return model;
}

class World {
 public:
  // `serves`: frames are an application's; else they are the master's own.
  World(bool serves, bool audits)
      : serves_(serves),
        master_(queue_, network_, network_.add_node({}), options(serves, audits), {}),
        slave_(queue_, network_, "s0", network_.add_node({}), master_.node(), honest_work()),
        stranger_(queue_, network_, network_.add_node({})) {
    master_.start();
    if (!serves_) {
      master_.loop().set_outcome_callback([this](const master::FrameOutcome& outcome) {
        if (open_frames_.erase(outcome.frame) != 1) std::abort();  // each ends once
      });
      commit();
    }
  }
  ~World() {
    stranger_.leave();
    slave_.kill(true);
    master_.kill(true);
  }

  void step(test::FuzzInput& input) {
    stranger_.step(input, master_.node(), [&](std::uint8_t kind) {
      if (kind == 0) return slave_.start();
      if (serves_) return test::run_for(queue_, std::chrono::milliseconds(1));
      if (kind == 1) return submit(input);
      if (input.below(4) == 0) return commit();
      master_.loop().cancel(input.below(8));
    });
  }

  void end() {
    stranger_.leave();
    slave_.start();
    if (serves_) return serve_honestly();
    submit_plain();
    if (!test::run_until(queue_, kPatienceSeconds, [this] { return open_frames_.empty(); }))
      std::abort();
    master_.loop().shutdown();
  }

 private:
  static master::FrameLoopOptions options(bool serves, bool audits) {
    master::FrameLoopOptions options;
    options.serves_applications = serves;
    options.isa = Isa::kScalar;
    options.audit.share = audits ? 0.5 : 0;
    options.memory = [] { return std::optional(kRoomBytes); };
    return options;
  }

  void commit() {
    ++version_;
    master_.loop().commit_scene(
        version_, sim::scene_of_tag(static_cast<int>(version_ % 2), sim::SceneWeight::kLight));
  }
  void submit_of(int width_px, int tile_edge_px) {
    if (next_frame_ >= 8) return;
    FrameSettings settings;
    settings.width_px = width_px;
    settings.height_px = 24;
    settings.tile_edge_px = tile_edge_px;
    settings.pixel_format = PixelFormat::kDisplay8;
    open_frames_.insert(next_frame_);
    master_.loop().submit(next_frame_++, version_, settings);
  }
  void submit(test::FuzzInput& input) {
    const int width_px = 1 + input.below(64);
    submit_of(width_px, 8 + input.below(24));
  }
  void submit_plain() { submit_of(32, 16); }

  void serve_honestly() {
    sim::AppScript script;
    script.frames = 2;
    script.width_px = script.height_px = 32;
    sim::SimApp app(queue_, network_, network_.add_node({}), master_.node(), script, 1,
                    {[](FrameId, const Status&) {}, [](const std::string&) { std::abort(); }});
    app.start();
    app.set_ending();
    const bool is_done = test::run_until(queue_, kPatienceSeconds, [&] { return app.is_done(); });
    app.kill(true);
    if (!is_done) std::abort();
  }

  const bool serves_;
  sim::EventQueue queue_{1};
  sim::Network network_{queue_, 1};
  sim::SimMaster master_;
  sim::SimSlave slave_;
  test::Stranger stranger_;
  SceneVersion version_ = 0;
  FrameId next_frame_ = 0;
  std::set<FrameId> open_frames_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  test::silence_log();
  test::FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  World world((kind & 1) != 0, (kind & 2) != 0);
  for (int i = 0; i < test::Stranger::kStepsMax && !input.is_at_end(); ++i) world.step(input);
  world.end();
  return 0;
}
