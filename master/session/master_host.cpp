// SPDX-License-Identifier: Apache-2.0
#include "master/session/master_host.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/base/cpu_count.h"
#include "common/base/descriptors.h"
#include "common/base/entropy.h"
#include "common/base/limits.h"
#include "common/base/local_name.h"
#include "common/base/log.h"
#include "common/base/memory_room.h"
#include "common/metrics/exposition.h"
#include "common/net/connector.h"
#include "common/net/key_store.h"
#include "common/net/local_pair.h"
#include "common/wire/codec.h"
#include "master/frame_loop/metrics_page.h"
#include "master/frame_loop/observer.h"
#include "slave/core/integrate/tile_renderer.h"

namespace tessera::master {
namespace {
const std::string kLocalName(kLocalNamePrefix);

// Embedding programs give numbers that no command line has looked at.
Status check_pulse(const SessionOptions& options) {
  const auto is_in = [](std::uint32_t value, std::uint32_t least, std::uint32_t most) {
    return value >= least && value <= most;
  };
  using net::Pulse;
  if (is_in(options.heartbeat_ms, Pulse::kHeartbeatMsLeast, Pulse::kHeartbeatMsMost) &&
      is_in(options.heartbeats_missed_max, 1, Pulse::kMissedMost))
    return Status::ok();
  return Status::invalid_argument("heartbeat of " + std::to_string(options.heartbeat_ms) + " ms, " +
                                  std::to_string(options.heartbeats_missed_max) +
                                  " missed: give 20 to 60000 ms and 1 to 100");
}

// What is audited where nobody said anything. With two certificates nobody could decide which of
// two pictures is wrong, and under mixed instruction sets honest slaves' pictures differ.
AuditOptions audit_of(const SessionOptions& options, bool serves_applications) {
  constexpr double kUsualShare = 0.01;
  constexpr std::size_t kUsualKeysMin = 3;
  if (options.audit_percent) return {*options.audit_percent / 100, 0, entropy()};
  if (!serves_applications || options.is_isa_mixed) return {};
  return {kUsualShare, kUsualKeysMin, entropy()};
}
}  // namespace

Status check_credentials(const SessionOptions& options, const net::Endpoint& endpoint,
                         const std::string& role) {
  if (!options.keys_folder.empty() && options.is_plain) {
    return Status::invalid_argument("--keys and --plain exclude each other; give one of them");
  }
  if (!options.keys_folder.empty()) return Status::ok();
  const std::string mend =
      "make keys with 'tessera-keys init cluster' and 'tessera-keys add cluster " + role +
      " NAME', then pass --keys cluster/NAME";
  if (!net::is_loopback(endpoint)) {
    return Status::invalid_argument(endpoint.text() +
                                    " is not loopback, so it needs keys: " + mend);
  }
  if (!options.is_plain) {
    return Status::invalid_argument(endpoint.text() +
                                    " needs --keys DIR, or --plain (loopback only): " + mend);
  }
  return Status::ok();
}

Result<std::shared_ptr<net::TlsContext>> load_credentials(const SessionOptions& options,
                                                          const net::Endpoint& endpoint,
                                                          const std::string& role) {
  TESSERA_RETURN_IF_ERROR(check_credentials(options, endpoint, role));
  if (options.is_plain) return std::shared_ptr<net::TlsContext>();
  return net::TlsContext::load(options.keys_folder, role);
}

MasterHost::MasterHost() = default;

Result<std::unique_ptr<MasterHost>> MasterHost::start(const SessionOptions& options,
                                                      bool serves_applications) {
  TESSERA_RETURN_IF_ERROR(check_pulse(options));
  if (!options.issue_from.empty() && options.listen.empty()) {
    return Status::invalid_argument(
        "--issue-from needs --listen: certificates are made for who connects");
  }
  std::unique_ptr<MasterHost> host(new MasterHost);
  if (!options.listen.empty()) raise_descriptor_limit();
  FrameLoopOptions loop_options;
  loop_options.prefetch_per_thread = options.prefetch_per_thread;
  loop_options.frames_in_flight = options.frames_in_flight;
  loop_options.is_static = options.is_static;
  loop_options.is_faulty_frame_failed = options.is_faulty_frame_failed;
  loop_options.is_scene_transfer_sync = options.is_scene_transfer_sync;
  loop_options.audit = audit_of(options, serves_applications);
  loop_options.slaves_min = options.slaves_min;
  loop_options.pulse = {options.heartbeat_ms, options.heartbeats_missed_max};
  loop_options.isa = options.isa;
  loop_options.is_isa_mixed = options.is_isa_mixed;
  loop_options.is_relaying = options.is_relaying;
  loop_options.is_pixel_coding = options.is_pixel_coding;
  loop_options.serves_applications = serves_applications;
  loop_options.memory = [cap_bytes = options.memory_mib << 20]() -> std::optional<std::uint64_t> {
    const std::optional<MemoryRoom> room = memory_room(cap_bytes);
    return room ? std::optional(room->free_bytes) : std::nullopt;
  };
  if (!options.issue_from.empty()) {
    loop_options.certificate_wanted = [h = host.get()](const net::PeerIdentity& peer,
                                                       std::vector<std::byte> request,
                                                       auto answer) {
      h->desk_->ask(peer, std::move(request), std::move(answer));
    };
  }
  loop_options.hasher = &host->hasher_;
  loop_options.surface_bytes = host->footprint_.surface_bytes();
  host->io_.run_and_wait(
      [&] { host->frame_loop_ = std::make_unique<FrameLoop>(host->io_, loop_options); });
  if (!options.listen.empty()) TESSERA_RETURN_IF_ERROR(host->listen_at(options));
  if (!options.metrics.empty()) TESSERA_RETURN_IF_ERROR(host->serve_metrics(options.metrics));
  if (!options.trace_path.empty()) TESSERA_RETURN_IF_ERROR(host->start_trace(options));
  TESSERA_RETURN_IF_ERROR(host->start_local_slaves(options));
  host->wait_for_local_slaves();
  return host;
}

MasterHost::~MasterHost() {
  for (auto& slave : slaves_) slave->stop();
  io_.run_and_wait([this] {
    if (desk_) desk_->close();
    credentials_.reset();
    listener_.reset();
    metrics_.reset();
    if (!frame_loop_) return;
    frame_loop_->observer().finish_trace();
    frame_loop_->shutdown();
  });
  desk_.reset();  // its last answers come before the frame loop goes
  slaves_.clear();
  if (slave_io_) slave_io_->stop();
  io_.run_and_wait([this] { frame_loop_.reset(); });
  io_.stop();
  if (trace_writer_.joinable()) trace_writer_.join();
}

Status MasterHost::serve_metrics(const std::string& address) {
  auto endpoint = net::parse_endpoint(address);
  if (!endpoint.is_ok()) {
    return Status::invalid_argument("--metrics " + endpoint.status().message());
  }
  Status status;
  io_.run_and_wait([&] {
    auto page = net::HttpPage::open(io_, *endpoint,
                                    {"/metrics", std::string(metrics::kContentType),
                                     [this] { return metrics_page(frame_loop_->status()); }});
    if (page.is_ok()) {
      metrics_ = std::move(*page);
      endpoint->port = metrics_->port();
    } else {
      status = Status(page.status().code(), "--metrics " + page.status().message());
    }
  });
  if (status.is_ok()) log_info("metrics", "at http://" + endpoint->text() + "/metrics");
  return status;
}

// The file is opened now, so that a wrong path is told before the work; it is written on a thread
// of its own, since the text of many tiles takes longer than a heartbeat may wait.
Status MasterHost::start_trace(const SessionOptions& options) {
  const std::string path = options.trace_path;
  TESSERA_RETURN_IF_ERROR(write_trace(Trace(), path));
  io_.run_and_wait([&] {
    frame_loop_->observer().start_trace(
        from_seconds(options.trace_seconds), [this, path](Trace trace) {
          trace_writer_ = std::thread([path, trace = std::move(trace)] {
            const Status status = write_trace(trace, path);
            if (!status.is_ok()) return log_error("trace-failed", status.message());
            log_info("trace-written", path,
                     {{"tiles", std::to_string(trace.tiles.size())},
                      {"dropped", std::to_string(trace.tiles_dropped)}});
          });
        });
  });
  return Status::ok();
}

Status MasterHost::listen_at(const SessionOptions& options) {
  auto endpoints = net::parse_endpoints(options.listen);
  if (!endpoints.is_ok())
    return Status::invalid_argument("--listen " + endpoints.status().message());
  for (const net::Endpoint& endpoint : *endpoints)
    TESSERA_RETURN_IF_ERROR(check_credentials(options, endpoint, "master"));
  auto tls = load_credentials(options, endpoints->front(), "master");
  if (!tls.is_ok()) return tls.status();
  if (*tls) {
    (*tls)->set_refusal([](const std::string& reason) {
      return wire::encode(wire::Refuse{wire::RefuseCode::kRole, reason});
    });
  }
  if (!options.issue_from.empty()) {
    if (!*tls)
      return Status::invalid_argument("--issue-from needs --keys: without, nobody has any");
    TESSERA_RETURN_IF_ERROR(net::check_issuing_folder(options.issue_from, options.keys_folder));
    desk_ = std::make_unique<CertificateDesk>(io_, options.issue_from, *tls);
  }
  Status status;
  io_.run_and_wait([&] {
    if (desk_) desk_->start();
    auto listener =
        net::listen_on_all(io_, *endpoints, *tls, [this](net::ConnectionPtr connection) {
          frame_loop_->accept(std::move(connection), listener_.get());
        });
    if (listener.is_ok()) {
      listener_ = std::move(*listener);
      if (*tls) credentials_ = std::make_unique<net::CredentialsWatch>(io_, *tls);
    } else {
      status = listener.status();
    }
  });
  if (!status.is_ok()) return status;
  for (std::size_t i = 0; i < endpoints->size(); ++i) {
    net::Endpoint& endpoint = (*endpoints)[i];
    endpoint.port = listener_->port(i);
    log_info("listening", "waiting for slaves at " + endpoint.text(),
             {{"link", *tls ? "tls" : "plain"}, {"port", std::to_string(endpoint.port)}});
  }
  return status;
}

net::LinkFactory MasterHost::local_link_factory() {
  return [this](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
    auto [ours, theirs] = net::make_local_pair(io_, *slave_io_);
    io_.post([this, ours = ours] { frame_loop_->accept(ours, nullptr); });
    slave_io_->post([theirs = theirs, on_connected] { on_connected(theirs); });
    return std::unique_ptr<net::ConnectAttempt>();
  };
}

Status MasterHost::start_local_slaves(const SessionOptions& options) {
  if (options.local_slaves <= 0) return Status::ok();
  const IsaMask supported = core::supported_isas();
  if (options.isa && (supported & isa_bit(*options.isa)) == 0) {
    std::string names;
    for (int i = 0; i < 4; ++i) {
      if (supported >> i & 1u) names += " " + std::string(isa_name(static_cast<Isa>(i)));
    }
    return Status::invalid_argument("--isa " + std::string(isa_name(*options.isa)) +
                                    ": this CPU does not have it; it has:" + names);
  }
  const int threads_all = options.local_threads > 0 ? options.local_threads : available_cpu_count();
  slave_io_ = std::make_unique<net::IoThread>("slave-net");
  for (int i = 0; i < options.local_slaves; ++i) {
    slave::SlaveOptions slave_options;
    slave_options.name = kLocalName + std::to_string(i + 1);
    slave_options.threads = std::clamp(
        threads_all / options.local_slaves + (i < threads_all % options.local_slaves ? 1 : 0), 1,
        kWorkersMax);
    slave_options.isas = supported;
    slaves_.push_back(
        std::make_unique<slave::SlaveHost>(*slave_io_, slave_options, local_link_factory()));
    slaves_.back()->start();
  }
  return Status::ok();
}

// Waits for the local slaves to join, which takes some milliseconds. Whoever asks for the status
// then sees them, and a session that ends at once breaks off no handshake.
void MasterHost::wait_for_local_slaves() {
  const TimePoint deadline = Clock::now() + std::chrono::milliseconds(kHandshakeMs);
  while (Clock::now() < deadline) {
    const ClusterStatus now = status();
    const auto present =
        std::count_if(now.slaves.begin(), now.slaves.end(),
                      [](const SlaveStatus& slave) { return slave.name.starts_with(kLocalName); });
    if (present >= static_cast<std::ptrdiff_t>(slaves_.size())) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

ClusterStatus MasterHost::status() {
  ClusterStatus status;
  io_.run_and_wait([&] { status = frame_loop_->status(); });
  return status;
}

}  // namespace tessera::master
