// SPDX-License-Identifier: Apache-2.0
#include "master/session/in_process_session.h"

#include <utility>

#include "common/scene/scene_codec.h"
#include "common/scene/validate.h"
#include "master/session/master_host.h"
#include "master/session/outcome_queue.h"
#include "slave/core/scene/patch_footprint.h"

namespace tessera::master {
namespace {

// Posted tasks hold the host itself: while the host is being destroyed its thread still runs them,
// and host_ is null by then.
class InProcessSession final : public Session {
 public:
  InProcessSession(std::unique_ptr<MasterHost> host, const SessionOptions& options)
      : outcomes_(options.frames_in_flight), host_(std::move(host)) {
    host_->io().run_and_wait([this] {
      host_->frame_loop().set_outcome_callback([this](FrameOutcome outcome) {
        outcomes_.push(
            {outcome.frame, std::move(outcome.status), std::move(outcome.image), outcome.stats});
      });
    });
  }

  ~InProcessSession() override {
    outcomes_.end(Status::closed("the session was closed"));
    host_.reset();  // joins; no outcome comes after it
  }

  Result<SceneVersion> commit_scene(const Scene& scene) override {
    TESSERA_RETURN_IF_ERROR(validator_.validate(scene));
    const SceneVersion version = ++version_;
    EncodedScene encoded = encoder_.encode(scene);
    // Cutting patches takes a while, so that the application's thread does it.
    encoded.index_bytes = footprint_.index_bytes_of(encoded, patches_.surface_bytes());
    host_->io().post([host = host_.get(), version, encoded = std::move(encoded)]() mutable {
      host->frame_loop().commit_scene(version, std::move(encoded));
    });
    return version;
  }

  Result<FrameId> submit(const FrameSettings& settings) override {
    TESSERA_RETURN_IF_ERROR(validate_frame_settings(settings));
    if (version_ == 0) return Status::invalid_argument("submit() before the first commit_scene()");
    auto frame = outcomes_.begin_frame();
    if (!frame.is_ok()) return frame;
    host_->io().post([host = host_.get(), frame = *frame, version = version_, settings] {
      host->frame_loop().submit(frame, version, settings);
    });
    return frame;
  }

  Result<FrameResult> next_frame(std::chrono::milliseconds timeout) override {
    return outcomes_.pop(timeout);
  }

  void cancel_frames() override {
    host_->io().post([host = host_.get()] { host->frame_loop().cancel_all(); });
  }

  ClusterStatus status() override { return host_->status(); }
  std::uint16_t listen_port() const override { return host_->listen_port(); }

 private:
  OutcomeQueue outcomes_;
  SceneValidator validator_;      // application thread
  SceneEncoder encoder_;          // application thread
  SceneFootprint footprint_;      // application thread
  core::PatchFootprint patches_;  // application thread
  SceneVersion version_ = 0;      // application thread
  std::unique_ptr<MasterHost> host_;
};

}  // namespace

Result<std::unique_ptr<Session>> open_in_process_session(const SessionOptions& options) {
  auto host = MasterHost::start(options, /*serves_applications=*/false);
  if (!host.is_ok()) return host.status();
  return std::unique_ptr<Session>(std::make_unique<InProcessSession>(std::move(*host), options));
}

}  // namespace tessera::master
