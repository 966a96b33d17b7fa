// SPDX-License-Identifier: Apache-2.0
#include "slave/scene_intake.h"

#include <utility>

#include "common/base/clock.h"
#include "common/base/entropy.h"
#include "common/base/log.h"
#include "common/net/event_loop.h"
#include "common/wire/codec.h"

namespace tessera::slave {
namespace {

// Pause between two reports of a transfer in work: an eighth of the window over which it is judged.
constexpr std::chrono::milliseconds kProgressPause{250};

}  // namespace

SceneIntake::SceneIntake(net::EventLoop& loop, wire::SceneReceiver::Room room,
                         const RelayAccess& access, Events events)
    : loop_(loop),
      access_(access),
      events_(std::move(events)),
      receiver_(std::move(room)),
      child_(loop, access_,
             {[this](const wire::SceneChunk& chunk) { return on_relayed_chunk(chunk); },
              [this](wire::RelayFailed failed) {
                log_warn("relay-failed", "the slave that fed us is given up: " + failed.reason,
                         {{"version", std::to_string(failed.version)}});
                orphan_of_ = failed.version;
                events_.send(std::move(failed));
              }}),
      progress_(loop) {}

void SceneIntake::open_relay(const std::string& local_host, wire::Hello& hello) {
  if (!access_.listen || !access_.connect) return;
  hello.relay_port = 0;
  if (!listener_ || relay_host_ != local_host) {
    feeder_.reset();  // before the door that its connections came through
    listener_.reset();
    auto listener = access_.listen(local_host, [this](net::ConnectionPtr connection) {
      if (feeder_) feeder_->accept(std::move(connection), listener_.get());
    });
    if (!listener.is_ok()) {
      const std::string reason = listener.status().message();
      if (std::exchange(relay_failure_, reason) != reason)
        log_warn("relay-off", "this slave feeds no others: " + reason);
      return;
    }
    relay_failure_.clear();
    listener_ = std::move(*listener);
    relay_host_ = local_host;
    relay_token_ = entropy();
    feeder_ = std::make_unique<RelayFeeder>(loop_, receiver_, relay_token_);
  }
  hello.relay_port = listener_->port();
  hello.relay_token = relay_token_;
}

Status SceneIntake::on_message(wire::Message message) {
  wire::SceneReceiver::Actions actions;
  if (const auto* chunk = std::get_if<wire::SceneChunk>(&message)) {
    TESSERA_RETURN_IF_ERROR(receiver_.chunk(*chunk, actions));
  } else if (const auto* list = std::get_if<wire::SceneChunkList>(&message)) {
    TESSERA_RETURN_IF_ERROR(receiver_.list(*list, actions));
  } else if (auto* announce = std::get_if<wire::SceneAnnounce>(&message)) {
    announced_ = Clock::now();
    TESSERA_RETURN_IF_ERROR(receiver_.announce(std::move(*announce), actions));
  } else if (const auto* from = std::get_if<wire::RelayFrom>(&message)) {
    return on_relay_from(*from);
  } else {
    return Status::data_loss(std::string(wire::message_name(message)) +
                             " does not belong on the scene connection");
  }
  return perform(std::move(actions));
}

Status SceneIntake::retire(SceneVersion first_kept) {
  wire::SceneReceiver::Actions actions;
  receiver_.retire(first_kept, actions);
  return perform(std::move(actions));
}

Status SceneIntake::perform(wire::SceneReceiver::Actions actions) {
  if (feeder_) {
    for (const SceneVersion version : actions.begun) feeder_->on_begun(version);
    for (const auto& arrival : actions.arrived) feeder_->on_arrived(arrival);
  }
  for (wire::SceneFailed& failed : actions.failed) {
    log_error("scene-failed", failed.reason, {{"version", std::to_string(failed.version)}});
    events_.send(std::move(failed));
  }
  for (wire::SceneNeed& need : actions.need) events_.send(std::move(need));
  for (wire::SceneChunkNeed& need : actions.chunk_need) {
    if (child_.is_following(need.version)) {
      child_.want(std::move(need));
    } else if (orphan_of_ != need.version) {
      events_.send(std::move(need));
    }  // else: lacking() has it when the master has spoken
  }
  for (wire::SceneReceiver::Complete& complete : actions.complete) {
    if (child_.is_following(complete.version)) child_.rest();
    log_received(complete);
    if (feeder_) events_.send(wire::SceneProgress{complete.version, complete.total_bytes});
    TESSERA_RETURN_IF_ERROR(events_.complete(std::move(complete)));
  }
  const bool is_in_work = feeder_ != nullptr && receiver_.head_version() != 0;
  if (is_in_work && !std::exchange(is_reporting_, true)) {
    progress_.start_repeating(kProgressPause, [this] { report_progress(); });
  }
  return Status::ok();
}

// Only a scene that a person waits for is news; an animation brings one with each frame.
void SceneIntake::log_received(const wire::SceneReceiver::Complete& complete) {
  const double took = seconds(Clock::now() - announced_);
  log_event(took >= 0.5 ? LogLevel::kInfo : LogLevel::kDebug, "scene-received", "a scene is here",
            {{"version", std::to_string(complete.version)},
             {"bytes", std::to_string(complete.total_bytes)},
             {"relayed_bytes", std::to_string(std::exchange(relayed_bytes_, 0))},
             {"seconds", std::to_string(took)}});
}

void SceneIntake::report_progress() {
  const SceneVersion version = receiver_.head_version();
  if (version != 0) return events_.send(wire::SceneProgress{version, receiver_.head_bytes()});
  is_reporting_ = false;
  progress_.cancel();
}

Status SceneIntake::on_relay_from(const wire::RelayFrom& from) {
  if (from.version != receiver_.head_version())
    return Status::ok();  // complete or retired meanwhile
  orphan_of_ = 0;
  if (from.feeder != 0) {
    if (!access_.connect) return Status::data_loss("RelayFrom for a slave that does not relay");
    child_.follow(from, receiver_.lacking());
    return Status::ok();
  }
  child_.stop();
  for (wire::SceneChunkNeed& need : receiver_.lacking()) events_.send(std::move(need));
  return Status::ok();
}

std::optional<wire::RelayFault> SceneIntake::on_relayed_chunk(const wire::SceneChunk& chunk) {
  wire::SceneReceiver::Actions actions;
  relayed_bytes_ += chunk.bytes.bytes.size();
  const auto fault = relay_fault_of(receiver_.take(chunk, actions));
  if (fault) return fault;
  if (Status status = perform(std::move(actions)); !status.is_ok()) {
    events_.breach(std::move(status));
  }
  return std::nullopt;
}

void SceneIntake::lost() {
  child_.stop();
  if (feeder_) feeder_->drop_all();
  receiver_.reset();
  orphan_of_ = 0;
  is_reporting_ = false;
  progress_.cancel();
}

void SceneIntake::close() {
  lost();
  listener_.reset();
}

}  // namespace tessera::slave
