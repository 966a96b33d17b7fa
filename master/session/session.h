// SPDX-License-Identifier: Apache-2.0
// The API that applications link: describe scenes, submit frames, take pictures.
//
// One interface, two implementations: a master inside this process (with slaves inside it, or
// listening for slaves), or a connection to a running `tessera-master serve`. Frames come out in
// the order of submission, each exactly once: delivered, failed with a reason, or cancelled.
//
// Threads. One application thread at a time calls commit_scene() and submit(); next_frame() may be
// called by another; status() by any. Nothing here runs application code on internal threads.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "common/base/api.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/scene/scene_edits.h"

namespace tessera {

struct SessionOptions {
  std::string connect;      // HOST:PORT of a running master; empty: a master inside this process
  std::string listen;       // HOST:PORT[,HOST:PORT...] for slaves and applications; empty: none
  int local_slaves = 0;     // slaves inside this process
  int local_threads = 0;    // render threads of all local slaves together; 0: all cores
  int slaves_min = 0;       // wait for so many slaves before the first frame
  std::string keys_folder;  // credentials; empty with is_plain: TCP without TLS, loopback only
  bool is_plain = false;
  std::string name = "app";
  std::optional<Isa> isa;  // bind the session to this instruction set; else the best that all have
  bool is_isa_mixed = false;     // --isa-policy mixed
  bool is_relaying = true;       // scenes go from slave to slave
  bool is_pixel_coding = true;   // slaves may code pixels (losslessly) where their link is slow
  int prefetch_per_thread = -1;  // tiles waiting per render thread, 0 to 15; -1: as each needs
  int frames_in_flight = 2;      // 1 or 2
  // --faulty-pixels fail: NaN, infinite or negative pixels fail their frame; else they are painted.
  bool is_faulty_frame_failed = false;
  // A link that is silent for so many heartbeats, and one, is dead; told to every peer. Those of an
  // application are given 15 s at least.
  std::uint32_t heartbeat_ms = 250;         // 20 to 60,000
  std::uint32_t heartbeats_missed_max = 4;  // 1 to 100
  bool is_static = false;                   // --schedule static: fixed tiles for each slave
  bool is_scene_transfer_sync = false;      // --scene-transfer sync: only while no frame is in work
  // Tiles that two slaves render, and that are compared. Nothing: 1 where applications are served
  // and more than two certificates of slaves are here, else 0.
  std::optional<double> audit_percent;
  // Most memory that frames and scenes may take the process to; 0: what the machine allows.
  std::uint64_t memory_mib = 0;
  // The rest is of a master inside this process.
  std::string metrics;       // HOST:PORT of a page of metrics, loopback; empty: none
  std::string issue_from;    // the authority's folder, to renew certificates with; empty: not
  std::string trace_path;    // a trace is written there; empty: none
  double trace_seconds = 0;  // from the first lease on; 0: the newest part of the whole run
};

struct FrameResult {
  FrameId frame = 0;
  // ok: image holds every pixel. kCancelled: on request. kUnavailable: trying again may help.
  // kResourceExhausted: it does not, as when a tile has ended as many slaves as it may.
  Status status;
  std::shared_ptr<const FrameImage> image;
  FrameStats stats;
};

class TESSERA_API Session {
 public:
  // Starts the master or connects. Returns: one line for a person on any failure.
  static Result<std::unique_ptr<Session>> open(const SessionOptions& options);
  virtual ~Session() = default;  // cancels what is in flight; orderly goodbye to slaves

  // Frames submitted from now on show this scene. What it shares by pointer with the scene before
  // is neither looked at nor sent again. Returns at once; data travels beside the frames
  // in work. Returns: validate_scene()'s refusal.
  virtual Result<SceneVersion> commit_scene(const Scene& scene) = 0;

  // The same of a scene that is changed piece by piece. The session looks at what has changed, and
  // sends that. A refused commit leaves the scene before.
  Result<SceneVersion> commit(SceneEdits& edits) { return commit_scene(edits.scene()); }

  // Blocks while frames_in_flight frames are unfinished, or two finished ones are undelivered.
  // Returns: the frame's number, kClosed, or kUnavailable when a remote master is of no more use
  // (it cannot hold the scene, or talks nonsense). One that is away is waited for.
  virtual Result<FrameId> submit(const FrameSettings& settings) = 0;

  // Waits for the next frame in order. Returns: kDeadlineExceeded after `timeout`, kClosed /
  // kUnavailable.
  virtual Result<FrameResult> next_frame(std::chrono::milliseconds timeout) = 0;

  // Gives up every frame not delivered yet; they come out of next_frame() as kCancelled.
  virtual void cancel_frames() = 0;

  virtual ClusterStatus status() = 0;

  // Why no frame can come now, for a person: a remote master was there, is away, and is looked for.
  // The frames that it had are given to it again. Empty: nothing of the kind. Any thread.
  virtual std::string interruption() { return {}; }
  virtual std::uint16_t listen_port() const = 0;  // 0 when nothing listens
};

}  // namespace tessera
