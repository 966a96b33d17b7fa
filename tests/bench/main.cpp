// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "common/base/cli_usage.h"
#include "common/base/json.h"
#include "common/base/version.h"
#include "slave/core/integrate/tile_renderer.h"
#include "tests/bench/accuracy_suite.h"
#include "tests/bench/beside_suite.h"
#include "tests/bench/build_suite.h"
#include "tests/bench/core_suite.h"
#include "tests/bench/deform_suite.h"
#include "tests/bench/demand_suite.h"
#include "tests/bench/exchange_suite.h"
#include "tests/bench/gi_suite.h"
#include "tests/bench/method_suite.h"
#include "tests/bench/move_suite.h"
#include "tests/bench/patch_suite.h"
#include "tests/bench/run_facts.h"
#include "tests/bench/scenes.h"
#include "tests/bench/thesis_suite.h"
#include "tests/bench/trim_suite.h"
#include "tests/bench/update_suite.h"

namespace {

int fail(int code, const std::string& text) {
  std::fprintf(stderr, "tessera-bench: %s\n", text.c_str());
  return code;
}

void add_list(tessera::JsonObject& all, const std::string& suite,
              const std::vector<std::string>& rows) {
  std::string list;
  for (const std::string& row : rows) list += (list.empty() ? "" : ",") + row;
  all.add_raw(suite, "[" + list + "]");
}

std::vector<std::string> usual_scenes(const std::string& suite, bool is_quick) {
  if (suite == "gi") return tessera::bench::gi_scene_names();
  if (suite == "patch") return {"teapot", "teapots"};
  if (is_quick) return {"interior", "knot"};
  return tessera::bench::scene_names();
}

// Of the suites that measure masters and not the core.
struct MasterSuites {
  tessera::bench::ExchangeOptions exchange;
  tessera::bench::UpdateOptions update;
};

tessera::Status run(std::vector<std::string> suites,
                    const tessera::bench::CoreSuiteOptions& options, const MasterSuites& masters,
                    const std::string& facts, const std::string& json_path) {
  if (suites.empty()) suites = {"core", "build", "accuracy"};
  tessera::JsonObject all;
  all.add_raw("run", facts);
  all.add("isa", std::string(tessera::isa_name(options.isa)));
  for (const std::string& suite : suites) {
    std::vector<std::string> scenes;
    if (suite == "exchange" || suite == "update") {
      const tessera::Status status =
          suite == "update" ? tessera::bench::run_update_suite(masters.update, scenes)
                            : tessera::bench::run_exchange_suite(masters.exchange, scenes);
      if (!status.is_ok()) return status;
      add_list(all, suite, scenes);
      continue;
    }
    const bool is_methods = suite == "patch" && options.with_methods;
    const auto run_suite = suite == "core"        ? tessera::bench::run_core_suite
                           : suite == "build"     ? tessera::bench::run_build_suite
                           : suite == "gi"        ? tessera::bench::run_gi_suite
                           : suite == "moves"     ? tessera::bench::run_move_suite
                           : suite == "deforming" ? tessera::bench::run_deform_suite
                           : suite == "demand"    ? tessera::bench::run_demand_suite
                           : suite == "beside"    ? tessera::bench::run_beside_suite
                           : is_methods           ? tessera::bench::run_method_suite
                           : suite == "patch"     ? tessera::bench::run_patch_suite
                           : suite == "trims"     ? tessera::bench::run_trim_suite
                           : suite == "thesis"    ? tessera::bench::run_thesis_suite
                                                  : tessera::bench::run_accuracy_suite;
    tessera::bench::CoreSuiteOptions of_suite = options;
    if (of_suite.scenes.empty()) of_suite.scenes = usual_scenes(suite, options.is_quick);
    for (const std::string& name : of_suite.scenes) {
      auto known = suite == "gi" || suite == "patch" ? usual_scenes(suite, options.is_quick)
                                                     : tessera::bench::scene_names();
      if (suite == "core") known.push_back("crowd");
      if (suite == "patch" && !is_methods) known.push_back("million");
      if (std::find(known.begin(), known.end(), name) == known.end())
        return tessera::Status::invalid_argument("--scene " + name + " is none of " + suite);
    }
    const tessera::Status status = run_suite(of_suite, scenes);
    if (!status.is_ok()) return status;
    add_list(all, is_methods ? "methods" : suite, scenes);
  }
  if (json_path.empty()) return tessera::Status::ok();
  std::ofstream file(json_path);
  file << all.text() << "\n";
  if (!file.flush()) return tessera::Status::unavailable(json_path + ": cannot be written");
  return tessera::Status::ok();
}

std::vector<std::string> all_scene_names() {
  std::vector<std::string> names = tessera::bench::scene_names();
  for (const std::string& name : tessera::bench::gi_scene_names()) names.push_back(name);
  for (const char* const name : {"crowd", "teapot", "teapots", "million"}) names.push_back(name);
  return names;
}

void add_exchange_options(CLI::App& app, tessera::bench::ExchangeOptions& exchange) {
  app.add_option("--connections", exchange.connections, "exchange: slaves (default: 8 64 500)")
      ->check(CLI::Range(1, 2000));
  app.add_option("--slave-threads", exchange.threads,
                 "exchange: of each slave; four tiles for each")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--seconds", exchange.seconds, "exchange: measured, of each row")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option("--minutes", exchange.minutes,
                 "exchange: only the master's memory, minute by minute, for so long")
      ->check(CLI::Range(0, 1440));
  app.add_option("--link", exchange.link, "exchange: both, plain, tls")
      ->check(CLI::IsMember({"both", "plain", "tls"}))
      ->capture_default_str();
}

void add_update_options(CLI::App& app, tessera::bench::UpdateOptions& update) {
  app.add_option("--triangles", update.triangles, "update: of the scenes (default: 10^4 to 10^7)")
      ->check(CLI::Range(128, 100'000'000));
  app.add_option("--objects", update.objects,
                 "update: that the scenes consist of. Of the slave's CPU time to the first tile "
                 "after a change, the change's own is what goes beyond that of a move of the "
                 "camera just before; both are printed")
      ->check(CLI::Range(1, 60'000))
      ->capture_default_str();
  app.add_option("--listen", update.listen,
                 "update: HOST:PORT for slaves (default: one is started on this machine)");
  app.add_option("--keys", update.keys_folder, "update: credentials of the master, with --listen");
  app.add_option("--slaves", update.slaves, "update: waited for, with --listen")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--link-name", update.link, "update: what slaves are reached by, for the reader");
}

void add_flags(CLI::App& app, tessera::bench::CoreSuiteOptions& options) {
  app.add_flag("--all-peers", options.with_all_peers,
               "beside Embree's build of high quality and its robust flag, too");
  app.add_flag("--methods", options.with_methods,
               "patch: the methods that frames may ask for and their variants, beside each other");
  app.add_flag("--sizes", options.with_sizes,
               "core: fans of 8 to 128 rays, too; build: a part of the triangles, too");
  app.add_flag("--keep-memory", options.keeps_memory,
               "build: the heap keeps what is freed, so that no build touches memory first");
  app.add_option("--size", options.size_px,
                 "core: pixels along a side of the picture, a multiple of 32")
      ->check(CLI::Range(32, 8192))
      ->capture_default_str();
  app.add_flag(
      "--quick", options.is_quick,
      "interior and knot, 512x512, 3 repeats; 4,000 rays a class; gi: a fifth of the size");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures the ray core, beside Embree where it was there when this was built.",
               "tessera-bench");
  app.set_version_flag("--version", std::string("tessera-bench ") + tessera::kBuildId);
  tessera::bench::CoreSuiteOptions options;
  MasterSuites masters;
  std::vector<std::string> suites;
  std::string isa = "auto", json_path;
  app.add_option(
         "SUITE", suites,
         "core: rays per CPU-second; build: time to build; accuracy: errors on hard cases; "
         "moves: time to prepare a scene in which one instance moved; "
         "deforming: structures that are fitted or built fast, beside Embree's; "
         "demand: the first frame of a scene whose meshes are built when rays meet them; "
         "patch: rays through patches, beside triangles of them; "
         "trims: whether points of patches are kept, by the number of loops; "
         "thesis: its tables of steps and tests; exchange: the master's tiles per second, beside "
         "a bare epoll loop; update: from an edit to its pixels; gi: global illumination, its "
         "speed and its error, on scenes of its "
         "own; "
         "default: the first three")
      ->check(CLI::IsMember({"core", "build", "accuracy", "moves", "deforming", "beside", "demand",
                             "patch", "trims", "thesis", "exchange", "update", "gi"}));
  const std::vector<std::string> scene_names = all_scene_names();
  app.add_option(
         "--scene", options.scenes,
         "interior, knot, building, field; core: crowd, too; gi: cornell, room; patch: teapot, "
         "teapots, million (default: all but crowd and million)")
      ->check(CLI::IsMember(scene_names));
  app.add_option("--rays", options.kinds, "primary, shadow, bounce (default: all)")
      ->check(CLI::IsMember({"primary", "shadow", "bounce"}));
  app.add_option("--only", options.only,
                 "only what has this in its name, beside the first; gi: error or speed");
  add_flags(app, options);
  app.add_option("--isa", isa, "auto, scalar, sse4, avx2, avx512")->capture_default_str();
  app.add_option("--repeats", options.repeats, "timed runs of each, interleaved; the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_exchange_options(app, masters.exchange);
  add_update_options(app, masters.update);
  app.add_option("--json", json_path, "write the figures to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    return fail(2, tessera::usage_text(app, error) + " (see 'tessera-bench --help')");
  }
  const tessera::IsaMask supported = tessera::core::supported_isas();
  options.isa = tessera::widest_isa(supported);
  if (isa != "auto") {
    const auto named = tessera::parse_isa(isa);
    if (!named.is_ok()) return fail(2, named.status().message());
    if ((supported & tessera::isa_bit(*named)) == 0) {
      return fail(1, "--isa " + isa + ": this CPU does not have it");
    }
    options.isa = *named;
  }
  if (options.size_px % 32 != 0) return fail(2, "--size: must be a multiple of 32");
  if (options.is_quick) {
    options.size_px = 512;
    options.repeats = std::min(options.repeats, 3);
  }
  masters.update.is_quick = options.is_quick;
  masters.update.repeats = options.repeats;
  masters.update.only = options.only;
  const tessera::Status status =
      run(suites, options, masters, tessera::bench::run_facts(argc, argv), json_path);
  return status.is_ok() ? 0 : fail(1, status.message());
}
