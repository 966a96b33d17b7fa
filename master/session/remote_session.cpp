// SPDX-License-Identifier: Apache-2.0
#include "master/session/remote_session.h"

#include <future>
#include <utility>

#include "common/base/entropy.h"
#include "common/base/limits.h"
#include "common/net/connector.h"
#include "common/net/credentials_watch.h"
#include "common/net/endpoint.h"
#include "common/net/key_renewal.h"
#include "common/scene/validate.h"
#include "master/session/lasting_client.h"
#include "master/session/master_host.h"
#include "master/session/outcome_queue.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kStatusDeadline{5000};
// Longer than the client itself waits for its first Welcome.
constexpr std::chrono::milliseconds kArrival{2 * kHandshakeMs + 500};

// The net thread and the client on it; destroyed in order, on the right threads.
struct Link {
  net::IoThread io{"app-net"};
  std::unique_ptr<net::CredentialsWatch> credentials;  // io thread; null without keys
  std::unique_ptr<LastingClient> client;               // io thread

  ~Link() {
    io.run_and_wait([this] {  // after every task posted so far
      credentials.reset();
      client.reset();
    });
    io.stop();
  }

  // Connects and shakes hands; blocks for at most twice kHandshakeMs, and a little.
  Status open(const SessionOptions& options, wire::Role role, LastingClient::Callbacks callbacks) {
    auto endpoint = net::parse_endpoint(options.connect);
    if (!endpoint.is_ok())
      return Status::invalid_argument("--connect " + endpoint.status().message());
    auto tls = load_credentials(options, *endpoint, "app");
    if (!tls.is_ok()) return tls.status();
    auto welcome = std::make_shared<std::promise<Status>>();
    auto is_answered = std::make_shared<bool>(false);  // io thread
    auto answer = [welcome, is_answered](Status status) {
      if (std::exchange(*is_answered, true)) return false;
      welcome->set_value(std::move(status));
      return true;
    };
    callbacks.on_welcome = [answer, forward = callbacks.on_welcome] {
      if (!answer(Status::ok()) && forward) forward();
    };
    callbacks.on_ended = [answer, forward = callbacks.on_ended](Status reason) {
      if (!answer(reason) && forward) forward(std::move(reason));
    };
    const AppIdentity identity{role, options.name, entropy()};
    io.post([this, endpoint = *endpoint, tls = *tls, identity, callbacks] {
      if (tls) credentials = std::make_unique<net::CredentialsWatch>(io, tls);
      const auto open_link = [this, endpoint, tls](auto on_connected) {
        return net::connect(io, endpoint, tls, "master", std::chrono::milliseconds(kHandshakeMs),
                            std::move(on_connected));
      };
      auto renewal =
          identity.role == wire::Role::kApp ? net::renewal_access(tls) : net::RenewalAccess{};
      client =
          std::make_unique<LastingClient>(io, identity, open_link, callbacks, std::move(renewal));
      client->start();
    });
    auto future = welcome->get_future();
    if (future.wait_for(kArrival) != std::future_status::ready) {
      return Status::deadline_exceeded(endpoint->text() + " does not answer as a Tessera master");
    }
    return future.get();
  }
};

// Posted tasks hold the link itself, as in InProcessSession; the link's client lives until its
// thread ends.
class RemoteSession final : public Session {
 public:
  explicit RemoteSession(const SessionOptions& options) : outcomes_(options.frames_in_flight) {}

  ~RemoteSession() override {
    outcomes_.end(Status::closed("the session was closed"));
    link_.reset();
  }

  Status open(const SessionOptions& options) {
    LastingClient::Callbacks callbacks;
    callbacks.on_frame = [this](FrameResult result) { outcomes_.push(std::move(result)); };
    callbacks.on_status = [this](ClusterStatus status) {
      MutexLock lock(status_mutex_);
      status_ = std::move(status);
    };
    callbacks.on_away = [this, master = options.connect](const Status& why) {
      MutexLock lock(status_mutex_);
      status_.slaves.clear();
      interruption_ = "the master at " + master + " is away and looked for: " + why.message();
    };
    callbacks.on_welcome = [this] {
      MutexLock lock(status_mutex_);
      interruption_.clear();
    };
    callbacks.on_ended = [this, master = options.connect](const Status& reason) {
      outcomes_.end(Status::unavailable("lost the master at " + master + ": " + reason.message()));
    };
    link_ = std::make_unique<Link>();
    TESSERA_RETURN_IF_ERROR(link_->open(options, wire::Role::kApp, std::move(callbacks)));
    status();
    return Status::ok();
  }

  Result<SceneVersion> commit_scene(const Scene& scene) override {
    TESSERA_RETURN_IF_ERROR(validator_.validate(scene));
    const SceneVersion version = ++version_;
    link_->io.post([link = link_.get(), version, encoded = encoder_.encode(scene)]() mutable {
      link->client->commit_scene(version, std::move(encoded));
    });
    return version;
  }

  Result<FrameId> submit(const FrameSettings& settings) override {
    TESSERA_RETURN_IF_ERROR(validate_frame_settings(settings));
    if (version_ == 0) return Status::invalid_argument("submit() before the first commit_scene()");
    auto frame = outcomes_.begin_frame();
    if (!frame.is_ok()) return frame;
    link_->io.post([link = link_.get(), frame = *frame, version = version_, settings] {
      link->client->submit(frame, version, settings);
    });
    return frame;
  }

  Result<FrameResult> next_frame(std::chrono::milliseconds timeout) override {
    return outcomes_.pop(timeout);
  }

  void cancel_frames() override {
    link_->io.post([link = link_.get()] { link->client->cancel_all(); });
  }

  // Asks for a fresh status, which a later call returns. Returns: the newest one that came.
  ClusterStatus status() override {
    link_->io.post([link = link_.get()] { link->client->request_status(); });
    MutexLock lock(status_mutex_);
    return status_;
  }

  std::string interruption() override {
    MutexLock lock(status_mutex_);
    return interruption_;
  }

  std::uint16_t listen_port() const override { return 0; }

 private:
  OutcomeQueue outcomes_;
  SceneValidator validator_;  // application thread
  SceneEncoder encoder_;      // application thread
  SceneVersion version_ = 0;  // application thread

  Mutex status_mutex_;
  ClusterStatus status_ TESSERA_GUARDED_BY(status_mutex_);
  std::string interruption_ TESSERA_GUARDED_BY(status_mutex_);

  std::unique_ptr<Link> link_;
};

}  // namespace

Result<std::unique_ptr<Session>> open_remote_session(const SessionOptions& options) {
  auto session = std::make_unique<RemoteSession>(options);
  TESSERA_RETURN_IF_ERROR(session->open(options));
  return std::unique_ptr<Session>(std::move(session));
}

Result<ClusterStatus> fetch_status(const SessionOptions& options) {
  Link link;
  auto reply = std::make_shared<std::promise<Result<ClusterStatus>>>();
  auto is_answered = std::make_shared<bool>(false);  // io thread
  auto answer = [reply, is_answered](Result<ClusterStatus> result) {
    if (!std::exchange(*is_answered, true)) reply->set_value(std::move(result));
  };
  LastingClient::Callbacks callbacks;
  callbacks.on_frame = [](FrameResult) {};
  callbacks.on_away = [answer](const Status& why) { answer(why); };  // it is asked once
  callbacks.on_status = [answer](ClusterStatus status) { answer(std::move(status)); };
  callbacks.on_ended = [answer](Status reason) { answer(std::move(reason)); };
  TESSERA_RETURN_IF_ERROR(link.open(options, wire::Role::kStatus, std::move(callbacks)));
  link.io.post([&link] { link.client->request_status(/*wants_events=*/true); });
  auto future = reply->get_future();
  if (future.wait_for(kStatusDeadline) != std::future_status::ready) {
    return Status::deadline_exceeded(options.connect + " did not answer in time");
  }
  return future.get();
}

}  // namespace tessera::master
