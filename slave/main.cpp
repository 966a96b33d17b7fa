// SPDX-License-Identifier: Apache-2.0
// tessera-slave: one slave daemon. Exit code 0: stopped on request; 1: failed; 2: wrong usage.
#include <sys/resource.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "common/base/clean_text.h"
#include "common/base/cpu_count.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/base/signal_watch.h"
#include "common/metrics/exposition.h"
#include "common/net/connector.h"
#include "common/net/credentials_watch.h"
#include "common/net/endpoint.h"
#include "common/net/http_page.h"
#include "common/net/listener.h"
#include "common/net/tls.h"
#include "common/wire/codec.h"
#include "slave/slave_cli.h"
#include "slave/slave_host.h"
#include "slave/slave_metrics.h"

namespace tessera::slave {
namespace {

int fail(const Status& status) {
  std::fprintf(stderr, "tessera-slave: %s\n", clean_text(status.message()).c_str());
  return 1;
}

Status serve_metrics(net::IoThread& io, const SlaveCommand& command,
                     std::unique_ptr<net::HttpPage>& page) {
  Status status;
  io.run_and_wait([&] {
    auto opened = net::HttpPage::open(io, *command.metrics,
                                      {"/metrics", std::string(metrics::kContentType),
                                       [n = command.options.threads] { return metrics_page(n); }});
    if (opened.is_ok()) {
      page = std::move(*opened);
      log_info("metrics", "at http://" + net::Endpoint{command.metrics->host, page->port()}.text() +
                              "/metrics");
    } else {
      status = Status(opened.status().code(), "--metrics " + opened.status().message());
    }
  });
  return status;
}

// How other slaves are reached: with our keys, or on loopback without. Empty with --relay-listen
// off.
RelayAccess relay_access(net::IoThread& io, const std::shared_ptr<net::TlsContext>& tls,
                         const std::optional<std::string>& wanted) {
  RelayAccess access;
  if (wanted == kRelayOff) {
    log_info("relay-off", "this slave feeds no others and is fed by none: --relay-listen off");
    return access;
  }
  access.listen = [&io, tls, wanted](const std::string& local_host,
                                     std::function<void(net::ConnectionPtr)> on_accept) {
    net::Endpoint place{wanted.value_or(local_host), 0};
    if (place.host.empty()) {
      return Result<std::unique_ptr<net::Listener>>(Status::unavailable(
          "the address by which the master is reached is not known; give --relay-listen"));
    }
    auto listener = net::listen(io, place, tls, std::move(on_accept));
    if (listener.is_ok()) {
      place.port = (*listener)->port();
      log_info("relay-listening", "other slaves may fetch scenes at " + place.text(),
               {{"link", tls ? "tls" : "plain"}, {"address", place.text()}});
    }
    return listener;
  };
  access.connect = [&io, tls](const net::Endpoint& feeder,
                              std::function<void(Result<net::ConnectionPtr>)> on_connected) {
    return net::connect(io, feeder, tls, "slave", std::chrono::milliseconds(kHandshakeMs),
                        std::move(on_connected));
  };
  return access;
}

int run(SlaveCommand command) {
  if (!command.cpus.empty()) {  // before any thread starts, since threads inherit it
    if (const Status status = limit_cpus(command.cpus); !status.is_ok()) return fail(status);
  }
  const SignalWatch signals(/*watches_hangup=*/!command.keys_folder.empty());  // the first thread
  init_log(command.log_level, command.log_format);
  std::shared_ptr<net::TlsContext> tls;
  if (!command.keys_folder.empty()) {
    Result<std::shared_ptr<net::TlsContext>> loaded =
        net::TlsContext::load(command.keys_folder, "slave");
    if (!loaded.is_ok()) return fail(loaded.status());
    tls = std::move(*loaded);
    tls->set_refusal([](const std::string& reason) {
      return wire::encode(wire::Refuse{wire::RefuseCode::kRole, reason});
    });
    if (command.is_name_given && command.options.name != tls->name()) {
      log_warn("name-unused",
               "--name " + command.options.name +
                   " is not used: with keys a slave is called as its certificate, '" + tls->name() +
                   "'; 'tessera-keys add DIR slave NAME' makes others");
    }
    command.options.name = tls->name();
  }
  log_info("slave-started", "looking for the master",
           {{"master", command.master.text()},
            {"name", command.options.name},
            {"threads", std::to_string(command.options.threads)}});

  net::IoThread io("net");
  std::unique_ptr<net::HttpPage> page;  // io thread
  if (command.metrics) {
    const Status status = serve_metrics(io, command, page);
    if (!status.is_ok()) return fail(status);
  }
  command.options.relay = relay_access(io, tls, command.relay_listen);
  command.options.renewal = net::renewal_access(tls);
  std::unique_ptr<net::CredentialsWatch> watch;  // io thread
  if (tls) io.run_and_wait([&] { watch = std::make_unique<net::CredentialsWatch>(io, tls); });
  // The priority is lowered after the net thread has started and before those that render and
  // build, which inherit it: heartbeats go out in time however busy the machine is with other
  // programs.
  if (command.nice > 0 && setpriority(PRIO_PROCESS, 0, command.nice) != 0) {
    log_warn("nice", std::string("--nice has no effect: ") + std::strerror(errno));
  }
  SlaveHost node(
      io, command.options,
      [&io, &command, tls](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
        return net::connect(io, command.master, tls, "master",
                            std::chrono::milliseconds(kHandshakeMs), std::move(on_connected));
      });
  node.start();
  constexpr std::chrono::seconds kSummaries{1};  // a signal wakes at once
  while (!signals.wait(kSummaries)) log_summaries();
  node.stop();
  io.run_and_wait([&] {
    watch.reset();
    page.reset();
  });
  io.stop();
  log_summaries(/*is_last=*/true);
  log_info("slave-stopped", "stopped on request");
  return 0;
}

}  // namespace
}  // namespace tessera::slave

int main(int argc, char** argv) {
  try {
    const tessera::slave::ParsedCommand parsed = tessera::slave::parse_command_line(argc, argv);
    return parsed.exit_code ? *parsed.exit_code : tessera::slave::run(parsed.command);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "tessera-slave: %s\n", tessera::clean_text(e.what()).c_str());
    return 1;
  }
}
