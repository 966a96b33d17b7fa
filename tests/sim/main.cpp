// SPDX-License-Identifier: Apache-2.0
// tessera-sim: the cluster in virtual time. Exit code 0: every invariant held; 1: one was broken;
// 2: wrong usage.
#include <malloc.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/log.h"
#include "common/base/near_word.h"
#include "tests/sim/scaling.h"
#include "tests/sim/storm.h"

namespace tessera::sim {
namespace {

constexpr const char* kUsage =
    "usage: tessera-sim [--seeds N] [--first N] [--seed N [--trace] [--log]]\n"
    "       tessera-sim scaling [thesis|large] [--costs DIR] [--master-us US]\n"
    "       tessera-sim predict [NAME=VALUE ...]\n"
    "  --seeds N   run N storms, one for each seed (1000)\n"
    "  --first N   the first seed (1)\n"
    "  --seed N    run this one alone and print its plan\n"
    "  --trace     print every message and fault of it\n"
    "  --log       what the product logs, too\n"
    "  scaling     speed over the number of slaves, as CSV: the thesis's cluster; up to 1000 "
    "slaves\n"
    "  --costs DIR     recordings of record_costs.py (default: those of the source tree)\n"
    "  --master-us US  CPU of the master for a tile, from 'tessera-bench exchange' (11)\n"
    "  predict     one cluster: slaves threads width height tile_ms spread delay_ms mbit\n"
    "              slave_mbit record_us in_flight prefetch frames tile scale; costs=FILE\n"
    "              instead of tile_ms and spread; one JSON line\n";

// Memory that is freed is filled with this, so that who still reads it is found out.
constexpr int kFreed = 0xdb;

struct Options {
  std::uint64_t first = 1, count = 1000;
  bool is_single = false, has_trace = false, has_log = false;
};

// Says in which seed a check of the product failed, which ends the process.
char last_words[256];

void say_last_words(int signal) {
  const auto length = std::strlen(last_words);
  if (write(STDOUT_FILENO, last_words, length) < 0) _exit(1);
  (void)signal;
  _exit(1);
}

int print_violation(std::uint64_t seed, const StormReport& report) {
  std::printf("FAILED seed %llu after %.3f s: %s\n  replay: tessera-sim --seed %llu --trace\n",
              static_cast<unsigned long long>(seed), report.at_seconds, report.violation.c_str(),
              static_cast<unsigned long long>(seed));
  return 1;
}

int run_single(const Options& options) {
  const StormPlan plan = draw_storm(options.first);
  std::fputs(describe(plan).c_str(), stdout);
  const StormReport report = run_storm(plan, options.has_trace);
  std::printf("%d frames delivered, %d not; %.3f s, %llu events, hash %016llx\n",
              report.frames_delivered, report.frames_failed, report.at_seconds,
              static_cast<unsigned long long>(report.events),
              static_cast<unsigned long long>(report.hash));
  return report.violation.empty() ? 0 : print_violation(options.first, report);
}

int run_many(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  std::uint64_t events = 0, chunks_relayed = 0;
  double virtual_seconds = 0;
  int delivered = 0, failed = 0;
  for (std::uint64_t seed = options.first; seed < options.first + options.count; ++seed) {
    std::snprintf(last_words, sizeof(last_words),
                  "FAILED seed %llu: I9: a check of the product failed, or it crashed\n"
                  "  replay: tessera-sim --seed %llu --trace\n",
                  static_cast<unsigned long long>(seed), static_cast<unsigned long long>(seed));
    const StormReport report = run_storm(draw_storm(seed));
    events += report.events;
    chunks_relayed += report.chunks_relayed;
    virtual_seconds += report.at_seconds;
    delivered += report.frames_delivered;
    failed += report.frames_failed;
    if (!report.violation.empty()) return print_violation(seed, report);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  std::printf(
      "%llu seeds: no invariant broken; %d frames delivered, %d failed or cancelled; %llu chunks "
      "from slave to slave; %.0f s of virtual time, %llu events in %.1f s\n",
      static_cast<unsigned long long>(options.count), delivered, failed,
      static_cast<unsigned long long>(chunks_relayed), virtual_seconds,
      static_cast<unsigned long long>(events), wall.count());
  return 0;
}

int wrong_usage(const std::string& text) {
  std::fprintf(stderr, "tessera-sim: %s (see 'tessera-sim --help')\n", text.c_str());
  return 2;
}

// known: the words that may stand in its place.
int unknown_word(const std::string& word, const std::vector<std::string>& known) {
  return wrong_usage("'" + word + "' is not known" + did_you_mean(word, known));
}

int complain(const Status& status) {
  std::fprintf(stderr, "tessera-sim: %s\n", status.message().c_str());
  return 2;
}

int run_predict(int argc, char** argv) {
  ScalingCase c;
  for (int i = 2; i < argc; ++i) {
    const char* const equals = std::strchr(argv[i], '=');
    const std::string name =
        std::string(argv[i]).substr(0, equals != nullptr ? std::size_t(equals - argv[i]) : 0);
    const double value = equals != nullptr ? std::strtod(equals + 1, nullptr) : 0;
    const std::pair<const char*, int*> counts[] = {{"slaves", &c.slaves},
                                                   {"threads", &c.threads},
                                                   {"width", &c.width_px},
                                                   {"height", &c.height_px},
                                                   {"in_flight", &c.frames_in_flight},
                                                   {"prefetch", &c.prefetch_per_thread},
                                                   {"tile", &c.tile_edge_px},
                                                   {"frames", &c.frames}};
    const std::tuple<const char*, double*, double> amounts[] = {
        {"tile_ms", &c.tile_seconds, 1e-3},
        {"spread", &c.tile_spread, 1},
        {"scale", &c.cost_scale, 1},
        {"delay_ms", &c.delay_seconds, 1e-3},
        {"mbit", &c.master_bytes_per_s, 125e3},
        {"slave_mbit", &c.slave_bytes_per_s, 125e3},
        {"record_us", &c.master_record_seconds, 1e-6}};
    bool is_known = false;
    if (name == "costs" && equals != nullptr) {
      Result<CostMap> costs = CostMap::read(equals + 1);
      if (!costs.is_ok()) return complain(costs.status());
      c.costs = std::make_shared<const CostMap>(std::move(*costs));
      is_known = true;
    }
    for (const auto& [known, place] : counts) {
      if (name == known) *place = static_cast<int>(value), is_known = true;
    }
    for (const auto& [known, place, unit] : amounts) {
      if (name == known) *place = value * unit, is_known = true;
    }
    if (equals == nullptr || !is_known) {
      std::vector<std::string> known = {"costs"};
      for (const auto& count : counts) known.emplace_back(count.first);
      for (const auto& amount : amounts) known.emplace_back(std::get<0>(amount));
      return unknown_word(equals == nullptr ? argv[i] : name, known);
    }
  }
  const ScalingResult r = run_scaling(c);
  std::printf(
      "{\"frames_per_s\": %.4f, \"utilisation\": %.4f, \"wire_share\": %.4f, "
      "\"master_cpu_share\": %.4f, \"bytes_per_frame\": %.0f, \"tile_px\": %d, \"limit\": "
      "\"%s\"}\n",
      r.frames_per_s, r.utilisation, r.wire_share, r.master_cpu_share, r.bytes_per_frame,
      r.tile_edge_px, r.limit().c_str());
  return 0;
}

int run_scaling_series(int argc, char** argv) {
  std::string which = "thesis";
  SeriesOptions options;
  options.costs_folder = TESSERA_SIM_COSTS;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const bool is_option = word == "--costs" || word == "--master-us";
    if (is_option && i + 1 >= argc) return wrong_usage(word + " needs a value");
    if (word == "--costs") {
      options.costs_folder = argv[++i];
    } else if (word == "--master-us") {
      options.master_tile_seconds = 1e-6 * std::strtod(argv[++i], nullptr);
    } else if (word == "thesis" || word == "large") {
      which = word;
    } else {
      return unknown_word(word, {"thesis", "large", "--costs", "--master-us"});
    }
  }
  return which == "thesis" ? print_thesis_series(options) : print_large_series(options);
}

int run(int argc, char** argv) {
  const std::string command = argc > 1 ? argv[1] : "";
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) != "--help") continue;
    std::fputs(kUsage, stdout);
    return 0;
  }
  if (command == "scaling" || command == "predict") {
    init_log(LogLevel::kOff, LogFormat::kText);
    return command == "scaling" ? run_scaling_series(argc, argv) : run_predict(argc, argv);
  }
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto number = [&]() -> std::uint64_t {
      return i + 1 < argc ? std::strtoull(argv[++i], nullptr, 10) : 0;
    };
    if (word == "--seeds") {
      options.count = number();
    } else if (word == "--first") {
      options.first = number();
    } else if (word == "--seed") {
      options.first = number();
      options.is_single = true;
    } else if (word == "--trace") {
      options.has_trace = true;
    } else if (word == "--log") {
      options.has_log = true;
    } else {
      return unknown_word(
          word, {"--seeds", "--first", "--seed", "--trace", "--log", "scaling", "predict"});
    }
  }
  init_log(options.has_log ? LogLevel::kDebug : LogLevel::kOff, LogFormat::kText);
  mallopt(M_PERTURB, kFreed);
  signal(SIGABRT, say_last_words);
  signal(SIGSEGV, say_last_words);
  return options.is_single ? run_single(options) : run_many(options);
}

}  // namespace
}  // namespace tessera::sim

int main(int argc, char** argv) { return tessera::sim::run(argc, argv); }
