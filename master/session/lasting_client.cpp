// SPDX-License-Identifier: Apache-2.0
#include "master/session/lasting_client.h"

#include <algorithm>
#include <utility>

#include "common/base/clock.h"
#include "common/base/entropy.h"
#include "common/base/limits.h"

namespace tessera::master {
namespace {

// From the first try to connect to Welcome.
constexpr std::chrono::milliseconds kArrival{2 * kHandshakeMs};

}  // namespace

LastingClient::LastingClient(net::EventLoop& loop, AppIdentity identity, net::LinkFactory open_link,
                             Callbacks callbacks, net::RenewalAccess renewal)
    : loop_(loop),
      identity_(std::move(identity)),
      open_link_(std::move(open_link)),
      callbacks_(std::move(callbacks)),
      renewal_(std::move(renewal)),
      backoff_(entropy()),
      timer_(loop) {}

LastingClient::~LastingClient() = default;

void LastingClient::connect() {
  // The answer goes by way of the queue, since it may come from inside the call.
  const auto on_answer = [this, alive = std::weak_ptr<int>(alive_),
                          generation = generation_](Result<net::ConnectionPtr> link) {
    if (alive.expired()) return;
    loop_.post([this, alive, generation, link = std::move(link)]() mutable {
      if (!alive.expired() && generation == generation_) on_connected(std::move(link));
    });
  };
  timer_.start_once(kArrival, [this] {
    lose(Status::deadline_exceeded("nobody answers as a Tessera master in time"));
  });
  attempt_ = open_link_(on_answer);
}

void LastingClient::on_connected(Result<net::ConnectionPtr> link) {
  attempt_.reset();
  if (!link.is_ok()) return lose(link.status());
  AppClient::Callbacks callbacks;
  callbacks.on_welcome = [this] { on_welcome(); };
  callbacks.on_frame = [this](FrameResult result) { on_frame(std::move(result)); };
  callbacks.on_status = callbacks_.on_status;
  callbacks.on_ended = [this](const Status& why) { lose(why); };
  client_ = std::make_unique<AppClient>(loop_, std::move(*link), identity_, std::move(callbacks),
                                        renewal_);
}

// Says again what has no answer yet: each scene, and the frames that show it before the next one
// takes its place.
void LastingClient::on_welcome() {
  if (std::exchange(is_there_, true)) return;
  was_welcomed_ = true;
  timer_.cancel();
  backoff_.session_began(Clock::now());
  auto frame = frames_.begin();
  for (const auto& [version, scene] : scenes_) {
    client_->commit_scene(version, scene);
    for (; frame != frames_.end() && frame->version == version; ++frame)
      client_->submit(frame->frame, version, frame->settings);
  }
  if (const auto on_welcome = callbacks_.on_welcome) on_welcome();
}

void LastingClient::on_frame(FrameResult result) {
  const auto frame = std::find_if(frames_.begin(), frames_.end(),
                                  [&](const Frame& f) { return f.frame == result.frame; });
  if (frame == frames_.end()) return;
  frames_.erase(frame);
  forget_scenes();
  breaches_ = 0;
  const auto on_frame = callbacks_.on_frame;
  on_frame(std::move(result));
}

void LastingClient::lose(const Status& why) {
  const Status reason = why;  // it may be what the link that goes now holds
  ++generation_;
  is_there_ = false;
  attempt_.reset();
  client_.reset();
  backoff_.session_ended(Clock::now());
  if (reason.code() == StatusCode::kDataLoss) ++breaches_;
  const bool is_final =
      !was_welcomed_ || breaches_ >= kBreachesMax || reason.code() == StatusCode::kInvalidArgument;
  if (is_final) return end(reason);
  timer_.start_once(backoff_.next(), [this] { connect(); });
  const std::weak_ptr<int> alive = alive_;
  if (const auto on_away = callbacks_.on_away) on_away(reason);
  if (!alive.expired()) give_up_cancelled();
}

void LastingClient::end(Status reason) {
  has_ended_ = true;
  timer_.cancel();
  frames_.clear();
  scenes_.clear();
  const Callbacks last = std::exchange(callbacks_, {});
  last.on_ended(std::move(reason));
}

void LastingClient::commit_scene(SceneVersion version, EncodedScene scene) {
  if (has_ended_) return;
  scenes_[version] = std::make_shared<const EncodedScene>(std::move(scene));
  forget_scenes();
  if (is_there_) client_->commit_scene(version, scenes_[version]);
}

void LastingClient::submit(FrameId frame, SceneVersion version, const FrameSettings& settings) {
  if (has_ended_) return;
  frames_.push_back({frame, version, settings});
  if (is_there_) client_->submit(frame, version, settings);
}

void LastingClient::cancel_all() {
  for (Frame& frame : frames_) frame.is_cancelled = true;
  if (is_there_) return client_->cancel_all();
  give_up_cancelled();
}

void LastingClient::request_status(bool wants_events) {
  if (is_there_) client_->request_status(wants_events);
}

// All frames before one that was given up were, too.
void LastingClient::give_up_cancelled() {
  const std::weak_ptr<int> alive = alive_;
  while (!alive.expired() && !frames_.empty() && frames_.front().is_cancelled) {
    FrameResult result;
    result.frame = result.stats.frame = frames_.front().frame;
    result.status = Status::cancelled("given up while the master was away");
    on_frame(std::move(result));
  }
}

void LastingClient::forget_scenes() {
  const SceneVersion newest = scenes_.empty() ? 0 : scenes_.rbegin()->first;
  const SceneVersion first = frames_.empty() ? newest : frames_.front().version;
  std::erase_if(scenes_, [&](const auto& scene) {
    return scene.first < first ||
           (scene.first != newest &&
            std::none_of(frames_.begin(), frames_.end(),
                         [&](const Frame& frame) { return frame.version == scene.first; }));
  });
}

}  // namespace tessera::master
