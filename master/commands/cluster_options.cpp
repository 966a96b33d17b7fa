// SPDX-License-Identifier: Apache-2.0
#include "master/commands/cluster_options.h"

#include <sstream>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

void add_watch_options(CLI::App& app, MasterOptions& o) {
  app.add_option("--metrics", o.session.metrics,
                 "serve metrics for Prometheus at http://HOST:PORT/metrics (loopback)")
      ->type_name("HOST:PORT");
  app.add_option("--trace", o.session.trace_path,
                 "write what every render thread did to this file, for ui.perfetto.dev")
      ->type_name("FILE.json");
  app.add_option("--trace-seconds", o.session.trace_seconds,
                 "trace so many seconds from the first tile on (default: to the end; of a long "
                 "run the last 100000 tiles)")
      ->check(number_in(0, 86400))
      ->type_name("SECONDS");
}

}  // namespace

CLI::Validator number_in(double low, double high) {
  return CLI::Validator(
      [low, high](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        if (is_number && value >= low && value <= high) return std::string();
        std::ostringstream reason;
        reason << "give a number from " << low << " to " << high << ", not " << text;
        return reason.str();
      },
      "");
}

void add_text(CLI::App& app, const char* name, std::string& value, const char* type,
              const char* help) {
  app.add_option(name, value, help)->capture_default_str()->type_name(type);
}

void add_log_options(CLI::App& app, MasterOptions& o, TypedOptions& t) {
  add_text(app, "--log-level", t.log_level, "LEVEL", "trace, debug, info, warn, error, off");
  add_text(app, "--log-format", t.log_format, "FORMAT", "text or json, on stderr");
  app.add_flag("--quiet", o.is_quiet, "no progress, and only warnings in the log");
  app.add_option("--config", t.config, "TOML file with the same names; the command line wins")
      ->type_name("FILE");
}

void add_key_options(CLI::App& app, MasterOptions& o) {
  app.add_option("--keys", o.session.keys_folder, "credentials folder made by tessera-keys")
      ->type_name("DIR");
  app.add_flag("--plain", o.session.is_plain, "TCP without TLS, loopback only");
}

void add_cluster_options(CLI::App& app, MasterOptions& o, TypedOptions& t) {
  app.add_option("--issue-from", o.session.issue_from,
                 "the cluster's folder with the authority's key: certificates of slaves, of\n"
                 "applications and this master's are renewed with it at two thirds of their life")
      ->type_name("DIR");
  app.add_option("--listen", o.session.listen,
                 "where slaves (and, with serve, applications) connect; again, or after a comma,\n"
                 "for each further link of this machine")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::Join)
      ->type_name("HOST:PORT");
  app.add_option("--local", t.local,
                 "slaves inside this process (default: 1 when nothing else gives slaves)")
      ->check(whole_in(0, kWorkersMax))
      ->type_name("N");
  app.add_option("--slaves", o.session.slaves_min, "wait for so many slaves before the first frame")
      ->check(whole_in(0, kConnectionsMax))
      ->type_name("N");
  app.add_option("--wait", o.wait_seconds,
                 "wait at most so many seconds for --slaves (default: for ever)")
      ->check(number_in(0, 1e6))
      ->type_name("SECONDS");
  app.add_option("--threads", t.threads,
                 "render threads of slaves inside this process (default: all)")
      ->check(whole_in(1u, std::uint32_t{kWorkersMax}))
      ->type_name("N");
  add_text(app, "--isa", t.isa, "SET",
           "auto, scalar, sse4, avx2, avx512: instruction set of the session");
  add_text(app, "--isa-policy", t.isa_policy, "POLICY",
           "same: one set per session; mixed: later slaves may have another");
  add_text(app, "--relay", t.relay, "on|off",
           "on: slaves pass scenes on to slaves; off: the master sends to each");
  add_text(app, "--pixel-coding", t.pixel_coding, "MODE",
           "auto: slaves on slow links code their pixels, losslessly; off: never");
  add_text(app, "--prefetch", t.prefetch, "N|auto",
           "tiles waiting per render thread of a slave, 0 to 15, or auto (as the network needs)");
  add_text(app, "--schedule", t.schedule, "KIND",
           "dynamic, or static (fixed tiles for each slave, to measure what balancing is worth)");
  add_text(app, "--faulty-pixels", t.faulty_pixels, "POLICY",
           "NaN, infinite or negative pixels, after a second slave's try: colour or fail");
  add_text(app, "--scene-transfer", t.scene_transfer, "KIND",
           "async, or sync (a new scene travels only while no frame is in work)");
  app.add_option(
         "--audit", o.session.audit_percent,
         "per cent of the tiles that two slaves render, and that are compared; a third one\n"
         "decides (default: with serve 1 while slaves with more than two certificates are\n"
         "here and all have one instruction set, else 0)")
      ->check(number_in(0, 100))
      ->type_name("P");
  app.add_option(
         "--memory", o.session.memory_mib,
         "most memory to take, in MiB (default: what the machine and its container allow);\n"
         "what does not fit is refused")
      ->check(whole_in(std::uint64_t{0}, std::uint64_t{1} << 24))
      ->type_name("MIB");
  add_text(app, "--heartbeat", t.heartbeat, "MS",
           "an idle peer shows so often that it lives, 20 to 60000 milliseconds");
  add_text(app, "--heartbeats-missed", t.heartbeats_missed, "N",
           "so many may be missed, 1 to 100; after one more the peer is taken for lost");
  app.add_option("--frames-in-flight", o.session.frames_in_flight, "1 or 2")
      ->check(whole_in(1, kFramesInFlightMax))
      ->capture_default_str()
      ->type_name("N");
  add_watch_options(app, o);
  add_key_options(app, o);
  add_log_options(app, o, t);
}

}  // namespace tessera::master
