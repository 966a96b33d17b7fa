// SPDX-License-Identifier: Apache-2.0
// An application of the simulated world: the product's LastingClient in a process, driven by a
// script. Each frame must come, however often the master goes and comes again. It looks at every
// picture and at the order in which frames come (I1, I2, I3 of the fault matrix).
//
// Threads. The simulation's one.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "master/session/lasting_client.h"
#include "tests/sim/network.h"
#include "tests/sim/picture.h"

namespace tessera::sim {

// What an application shows, and what it got.
struct AppScript {
  int frames = 10;  // at least, and until it is told to end
  int width_px = 64, height_px = 48, tile_edge_px = 8;
  int in_flight = 2;
  double scene_change = 0.3;  // probability before each frame
  double cancel = 0;          // probability after each frame: gives up what is in flight
  double pause_seconds = 0;   // between a frame and the next, at most
  SceneWeight weight = SceneWeight::kLight;
};

class SimApp {
 public:
  struct Events {
    std::function<void(FrameId, const Status&)> on_outcome;
    std::function<void(const std::string& what)> on_violation;
  };

  SimApp(EventQueue& queue, Network& network, int node, int master_node, AppScript script,
         std::uint64_t seed, Events events);

  void start();
  void kill(bool is_power_lost);
  void set_hung(bool is_hung);
  void cancel();

  bool is_running() const { return process_ != nullptr; }
  bool is_hung() const { return process_ && process_->is_hung(); }
  // From now on the application submits no more frames than the script has.
  void set_ending() { is_ending_ = true; }
  bool is_done() const { return is_ending_ && delivered_ >= script_.frames && frames_.empty(); }
  bool is_waiting() const { return client_ && !frames_.empty(); }
  int delivered() const { return delivered_; }
  Process* process() const { return process_.get(); }
  int node() const { return node_; }

 private:
  struct Frame {
    FrameId frame = 0;
    Shown shown;
    FrameSettings settings;
    bool is_cancelled = false;
  };

  void begin();
  void look_at_loss(const Status& why);
  void on_ended(const Status& status);
  void submit_more();
  void on_frame(const FrameResult& result);
  void check_picture(const Frame& frame, const FrameImage& image);
  void violation(const std::string& what) { events_.on_violation(what); }

  EventQueue& queue_;
  Network& network_;
  const int node_, master_node_;
  const AppScript script_;
  Random random_, times_;
  const Events events_;
  std::unique_ptr<Process> process_;
  std::unique_ptr<master::LastingClient> client_;
  bool is_welcomed_ = false;  // ever, by client_
  SceneVersion version_ = 0;
  int tag_ = 0;
  std::uint64_t starts_ = 0;  // of clients
  FrameId next_frame_ = 0;
  std::uint32_t next_seed_ = 0;
  std::deque<Frame> frames_;  // submitted, no outcome yet
  int delivered_ = 0;
  bool is_ending_ = false;
};

}  // namespace tessera::sim
