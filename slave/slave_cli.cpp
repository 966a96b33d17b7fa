// SPDX-License-Identifier: Apache-2.0
#include "slave/slave_cli.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>

#include "common/base/clean_text.h"
#include "common/base/cli_usage.h"
#include "common/base/cpu_count.h"
#include "common/base/limits.h"
#include "common/base/version.h"
#include "slave/core/integrate/tile_renderer.h"

namespace tessera::slave {

namespace {

constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

// What the person wrote, before it is checked.
struct Words {
  std::string master;
  int threads = 0;
  std::string isa = "auto";
  std::string structure = "auto";
  std::string build = "auto";
  std::string name;
  std::string keys_folder;
  bool is_plain = false;
  std::string log_level = "info";
  std::string log_format = "text";
  bool is_quiet = false;
  TestHooks hooks;
  int nice = 0;
  std::string cores;
  std::string metrics;
  std::string relay_listen;
  std::uint64_t memory_mib = 0;
};

ParsedCommand failed(int exit_code, const std::string& what) {
  std::fprintf(stderr, "tessera-slave: %s\n", clean_text(what).c_str());
  return {{}, exit_code};
}

bool is_printable(const std::string& text) {
  for (const char c : text) {
    if (c < 0x20 || c > 0x7e) return false;
  }
  return true;
}

std::string default_name() {
  std::array<char, 256> buffer{};
  if (gethostname(buffer.data(), buffer.size() - 1) != 0) return "slave";
  const std::string name = std::string(buffer.data()).substr(0, kNameBytesMax);
  return name.empty() || !is_printable(name) ? "slave" : name;
}

std::string isa_list(IsaMask mask) {
  std::string text;
  for (const Isa isa : {Isa::kScalar, Isa::kSse4, Isa::kAvx2, Isa::kAvx512}) {
    if ((mask & isa_bit(isa)) == 0) continue;
    if (!text.empty()) text += ", ";
    text += isa_name(isa);
  }
  return text;
}

void declare_hooks(CLI::App& app, TestHooks& hooks) {
  constexpr int kTilesMax = 1'000'000;
  app.add_option("--test-tile-sleep-ms", hooks.tile_sleep_ms)->check(CLI::Range(0, 60'000));
  app.add_option("--test-abort-at-tile", hooks.tile_aborted_at)->check(CLI::Range(0, kTilesMax));
  app.add_option("--test-freeze-at-tile", hooks.tile_frozen_at)->check(CLI::Range(0, kTilesMax));
  app.add_option("--test-abort-in-frame", hooks.frame_aborted_in)->check(CLI::Range(0, kTilesMax));
  app.add_option("--test-abort-in-tile", hooks.tile_aborted_in)->check(CLI::Range(0, kTilesMax));
  app.add_option("--test-abort-after-ms", hooks.abort_after_ms)->check(CLI::Range(0, 60'000));
  app.add_option("--test-wrong-tile-every", hooks.tile_wrong_every)
      ->check(CLI::Range(0, kTilesMax));
  app.add_flag("--test-wrong-scene", hooks.is_scene_wrong);
  for (CLI::Option* option : app.get_options()) {
    if (option->get_name().starts_with("--test-")) option->group("");  // not shown
  }
}

void declare(CLI::App& app, Words& words) {
  app.add_option("--master", words.master, "where the master listens")
      ->required()
      ->type_name("HOST:PORT");
  app.add_option("--threads", words.threads, "render threads (default: all this process may use)")
      ->check(CLI::Range(1, kWorkersMax));
  app.add_option("--cores", words.cores,
                 "processors to run on, rendering, building and all: how many (4) or which (0-3,8)")
      ->type_name("N|LIST");
  app.add_option("--nice", words.nice,
                 "give way to other programs: 0 (as they) to 19 (only what they leave)")
      ->check(CLI::Range(0, 19))
      ->capture_default_str();
  app.add_option("--metrics", words.metrics,
                 "serve metrics for Prometheus at http://HOST:PORT/metrics (loopback)")
      ->type_name("HOST:PORT");
  app.add_option("--relay-listen", words.relay_listen,
                 "address at which other slaves fetch scenes (default: that by which the master\n"
                 "is reached), or off: this slave feeds no others and is fed by none")
      ->type_name("ADDRESS");
  app.add_option("--isa", words.isa,
                 "instruction set to offer: auto (all this CPU has), scalar, sse4, avx2, avx512")
      ->type_name("NAME")
      ->capture_default_str();
  app.add_option("--structure", words.structure,
                 "what rays go through: auto, bvh, kd, kd-quality (twice as long to build),\n"
                 "bvh-quality (up to thrice, faster where large triangles overlap);\n"
                 "pictures do not depend on it")
      ->check(CLI::IsMember(core::structure_names()).description(""))
      ->type_name("NAME")
      ->capture_default_str();
  app.add_option("--build", words.build,
                 "when meshes are built: auto (with their scene) or on-demand (when the first ray\n"
                 "reaches them: less memory and a sooner first frame where much is hidden;\n"
                 "not for patches); pictures do not depend on it")
      ->check(CLI::IsMember({"auto", "on-demand"}).description(""))
      ->type_name("WHEN")
      ->capture_default_str();
  app.add_option(
         "--memory", words.memory_mib,
         "most memory to take, in MiB (default: what the machine and its container allow);\n"
         "a scene that needs more is refused before it is sent")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 30))
      ->type_name("MIB");
  app.add_option("--name", words.name,
                 "name shown by the master (default: the host's); with --keys it is the\n"
                 "certificate's")
      ->type_name("NAME");
  auto* keys = app.add_option("--keys", words.keys_folder,
                              "credentials folder of this slave, made by tessera-keys")
                   ->type_name("DIR");
  app.add_flag("--plain", words.is_plain, "no encryption; only for a master on this machine")
      ->excludes(keys);
  app.add_option("--log-level", words.log_level, "trace, debug, info, warn, error or off")
      ->type_name("LEVEL")
      ->capture_default_str();
  app.add_option("--log-format", words.log_format, "text or json")
      ->check(CLI::IsMember({"text", "json"}))
      ->type_name("FORMAT")
      ->capture_default_str();
  app.add_flag("--quiet", words.is_quiet, "errors only");
  declare_hooks(app, words.hooks);
}

// Without keys nobody beyond this machine may knock.
Status check_relay(const Words& words, SlaveCommand& command) {
  if (words.relay_listen.empty()) return Status::ok();
  command.relay_listen = words.relay_listen;
  if (words.relay_listen == kRelayOff || !words.is_plain ||
      net::is_loopback({words.relay_listen, 0}))
    return Status::ok();
  return Status::invalid_argument("--relay-listen " + words.relay_listen +
                                  " is not loopback, and --plain has no keys: give 127.0.0.1, off, "
                                  "or --keys DIR");
}

// Checks processors, priority and the page of metrics. Returns: kInvalidArgument, one line.
Status check_machine(const Words& words, SlaveCommand& command) {
  command.nice = words.nice;
  if (!words.cores.empty()) {
    auto cpus = parse_cpus(words.cores, allowed_cpus());
    if (!cpus.is_ok()) return Status::invalid_argument("--cores " + cpus.status().message());
    command.cpus = std::move(*cpus);
  }
  int threads = available_cpu_count();
  if (!command.cpus.empty()) threads = std::min(threads, static_cast<int>(command.cpus.size()));
  command.options.threads = words.threads > 0 ? words.threads : threads;
  if (words.metrics.empty()) return Status::ok();
  const Result<net::Endpoint> metrics = net::parse_endpoint(words.metrics);
  if (!metrics.is_ok()) {
    return Status::invalid_argument("--metrics " + metrics.status().message());
  }
  if (!net::is_loopback(*metrics)) {
    return Status::invalid_argument("--metrics " + words.metrics +
                                    " is not loopback, and the page has neither keys nor "
                                    "encryption: give 127.0.0.1:PORT");
  }
  command.metrics = *metrics;
  return Status::ok();
}

ParsedCommand check_words(const Words& words) {
  SlaveCommand command;
  SlaveOptions& options = command.options;
  const Result<net::Endpoint> master = net::parse_endpoint(words.master);
  if (!master.is_ok()) return failed(kExitUsage, "--master " + master.status().message());
  command.master = *master;
  if (command.master.host.empty() || command.master.port == 0) {
    return failed(kExitUsage, "--master " + words.master + ": give a host and a port, HOST:PORT");
  }
  if (!words.is_plain && words.keys_folder.empty()) {
    return failed(kExitUsage,
                  "give --keys DIR (credentials, made by 'tessera-keys add DIR slave NAME'), or "
                  "--plain for a master on this machine");
  }
  if (words.is_plain && !net::is_loopback(command.master)) {
    return failed(kExitUsage, "--plain is for a master on this machine, and " + words.master +
                                  " is not a loopback address: give --keys DIR instead");
  }
  command.keys_folder = words.keys_folder;
  command.is_name_given = !words.name.empty();
  options.name = words.name.empty() ? default_name() : words.name;
  if (options.name.size() > kNameBytesMax || !is_printable(options.name)) {
    return failed(kExitUsage, "--name: 1 to " + std::to_string(kNameBytesMax) +
                                  " printable ASCII characters are allowed");
  }
  if (const Status status = check_machine(words, command); !status.is_ok()) {
    return failed(kExitUsage, status.message());
  }
  if (const Status status = check_relay(words, command); !status.is_ok()) {
    return failed(kExitUsage, status.message());
  }
  options.hooks = words.hooks;
  options.memory = [cap_bytes = words.memory_mib << 20] { return memory_room(cap_bytes); };
  const Result<LogLevel> level = parse_log_level(words.log_level);
  if (!level.is_ok()) return failed(kExitUsage, level.status().message());
  command.log_level = words.is_quiet ? LogLevel::kError : *level;
  command.log_format = words.log_format == "json" ? LogFormat::kJson : LogFormat::kText;
  const IsaMask supported = core::supported_isas();
  options.isas = supported;
  options.structure = *core::parse_structure(words.structure);
  options.is_on_demand = words.build == "on-demand";
  if (options.is_on_demand && words.structure != "auto" && words.structure != "bvh") {
    return failed(kExitUsage, "--build on-demand goes with --structure auto or bvh: " +
                                  words.structure + " is built with its scene");
  }
  if (words.isa != "auto") {
    const Result<Isa> isa = parse_isa(words.isa);
    if (!isa.is_ok()) return failed(kExitUsage, isa.status().message());
    options.isas = isa_bit(*isa);
    if ((supported & options.isas) == 0) {
      return failed(kExitFailed, "--isa " + words.isa + ": this CPU does not have it; it has " +
                                     isa_list(supported));
    }
  }
  return {command, std::nullopt};
}

}  // namespace

ParsedCommand parse_command_line(int argc, char** argv) {
  CLI::App app("Renders tiles for a tessera-master, until it is told to stop (SIGTERM).",
               "tessera-slave");
  app.set_version_flag("--version", std::string("tessera-slave ") + kBuildId);
  Words words;
  declare(app, words);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return {{}, app.exit(success)};
  } catch (const CLI::ParseError& error) {
    return failed(kExitUsage, usage_text(app, error) + " (see 'tessera-slave --help')");
  }
  return check_words(words);
}

}  // namespace tessera::slave
