// SPDX-License-Identifier: Apache-2.0
// The master's heart on the net thread: owns the cluster of slaves, the scheduler, the scene
// broadcast and the two framebuffers, and turns submitted frames into finished ones, in order.
//
// Threads. Net thread only; callbacks run there too.
//
// Invariants. (1) At most frames_in_flight frames are leased at once; further submitted frames wait
// (bounded by the caller). (2) Frames finish in the order of submission, each once. (3) A tile is
// leased only to slaves that acknowledged the frame's scene version as built. (4) A pixel is
// written once, from a result that answered an outstanding lease (session, frame, version, tile,
// attempt).
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "common/base/ids.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/net/connection.h"
#include "common/net/event_loop.h"
#include "common/net/listener.h"
#include "common/net/liveness.h"
#include "common/scene/scene_codec.h"
#include "common/scene/scene_footprint.h"
#include "master/cluster/certificate_wish.h"
#include "master/frame_loop/frame_admission.h"
#include "master/frame_loop/frame_orders.h"
#include "master/schedule/audit_choice.h"

namespace tessera::master {

class Observer;

struct FrameLoopOptions {
  int prefetch_per_thread = -1;  // tiles waiting per render thread; -1: as each slave needs
  int frames_in_flight = 2;
  int slaves_min = 0;      // no frame starts before so many slaves have joined
  std::optional<Isa> isa;  // else the widest that all slaves have when the first frame starts
  bool is_isa_mixed = false;
  bool is_static = false;               // fixed tiles for each slave
  bool is_scene_transfer_sync = false;  // a scene is sent when no frame is in work
  AuditOptions audit;                   // tiles that two slaves render, and that are compared
  bool is_relaying = true;              // slaves feed slaves
  bool is_pixel_coding = true;          // slaves may code pixels where their link is slow
  bool is_faulty_frame_failed = false;  // else NaN, infinite, negative pixels get the error colour
  net::Pulse pulse;                     // of links; that of a far slave is slower
  bool serves_applications = false;     // accept role app (serve); else such peers are refused
  FrameAdmission::Room memory = {};     // what this process may take; null: no limit is known
  CertificateWish certificate_wanted = {};  // by peers; null: none are made
  // What preparing surfaces takes; null: by number of patches. Called on the hasher's thread.
  SurfaceBytes surface_bytes = {};
  // Computes frames' digests, and weighs surfaces; null: the loop itself, at once.
  net::EventLoop* hasher = nullptr;
};

class FrameLoop final : public FrameOrders {
 public:
  FrameLoop(net::EventLoop& io, const FrameLoopOptions& options);
  ~FrameLoop() override;

  // A fresh connection from a listener or a local pair; its Hello decides what it is.
  // `listener` is told when the peer has authenticated itself, and may be null (local pairs).
  void accept(net::ConnectionPtr connection, net::Listener* listener);

  void set_outcome_callback(std::function<void(FrameOutcome)> on_outcome) override;
  void weigh(EncodedScene scene, std::function<void(EncodedScene)> on_weighed) override;
  void commit_scene(SceneVersion version, EncodedScene scene) override;
  void submit(FrameId frame, SceneVersion version, const FrameSettings& settings) override;
  void cancel(FrameId frame) override;
  void cancel_all() override;
  void free_scenes() override;
  ClusterStatus status() const override;
  std::optional<std::uint64_t> free_bytes() const override;

  ClusterStatus counts() const;  // without pace, for callers that look after every event
  Observer& observer();          // accounts, metrics, traces

  // Says goodbye to every peer; every frame ends as kClosed. Nothing is accepted afterwards.
  void shutdown();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::master
