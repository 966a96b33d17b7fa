// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/core_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "common/base/cpu_count.h"
#include "common/base/json.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/simd/counts_layout.h"
#include "tests/bench/contender.h"
#include "tests/bench/cost_fit.h"
#include "tests/bench/cpu_turns.h"
#include "tests/bench/scenes.h"
#include "tests/bench/workload.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

struct Row {
  const Contender* contender = nullptr;
  std::vector<std::vector<double>> cpu_seconds{};             // of one thread, by processor
  std::vector<double> all_cpu_seconds{}, all_wall_seconds{};  // with all threads
  std::uint64_t hits = 0, different = 0;                      // from the first row's primitives
  double sum_t = 0;
  core::KernelCounts counts{};  // of one run, where the build counts
  CostFit costs{};              // of all runs, where the build counts
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : (values[n / 2] + values[(n - 1) / 2]) / 2;
}

// Compares what the warm-up found with what the first contender found.
void compare(Row& row, const Workload& work, const std::vector<BlockHits>& hits,
             std::vector<FirstHit>& first) {
  const bool is_first = first.empty();
  std::size_t number = 0;
  for (std::size_t b = 0; b < work.blocks.size(); ++b) {
    for (int i = 0; i < work.blocks[b].count; ++i, ++number) {
      const std::uint32_t primitive = hits[b].primitive[i];
      if (is_first) first.push_back({hits[b].t[i], primitive});
      if (primitive != first[number].primitive) ++row.different;
      if (primitive == core::kNoPrimitive) continue;
      ++row.hits;
      row.sum_t += static_cast<double>(hits[b].t[i]);
    }
  }
}

void time_all_threads(Row& row, const Workload& work, std::vector<BlockHits>& hits) {
  const double start = process_cpu_seconds(), start_wall = wall_seconds();
  core::run_tasks(static_cast<int>(work.blocks.size()), available_cpu_count(), [&](int i) {
    const auto b = static_cast<std::size_t>(i);
    row.contender->trace(work.blocks[b], hits[b]);
  });
  row.all_cpu_seconds.push_back(process_cpu_seconds() - start);
  row.all_wall_seconds.push_back(wall_seconds() - start_wall);
}

// Traces a block. In a build that counts, adds the steps of the block and its cycles to the row.
void trace_block(Row& row, const RayBlock& rays, BlockHits& hits) {
#ifdef TESSERA_COUNTING
  core::kernel_counts = {};
  const std::uint64_t start = time_stamp();
  row.contender->trace(rays, hits);
  const std::uint64_t cycles = time_stamp() - start;
  const core::KernelCounts& c = core::kernel_counts;
  if (c.nodes + c.blocks > 0) row.costs.add(c, static_cast<double>(cycles));
  using Counts = core::KernelCounts;
  for (const auto field :
       {&Counts::packets, &Counts::singles, &Counts::nodes, &Counts::children, &Counts::blocks,
        &Counts::candidates, &Counts::row_tests, &Counts::times, &Counts::exact}) {
    row.counts.*field += c.*field;
  }
#else
  row.contender->trace(rays, hits);
#endif
}

void trace_blocks(Row& row, const Workload& work, std::vector<BlockHits>& hits) {
  for (std::size_t b = 0; b < work.blocks.size(); ++b) trace_block(row, work.blocks[b], hits[b]);
}

// Runs all contenders of one kind of ray. Returns: what the first of them has hit.
std::vector<FirstHit> measure(std::vector<Row>& rows, const Workload& work, int repeats) {
  std::vector<FirstHit> first;
  std::vector<BlockHits> hits(work.blocks.size());
  const CpuTurns turns;
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 chance;  // the same in each run
  for (int repeat = -1; repeat < repeats; ++repeat) {
    // What was traced just before has its effect on a processor's clock for a while. So each row
    // follows another one each time.
    if (repeat >= 0) std::shuffle(order.begin(), order.end(), chance);
    for (const std::size_t number : order) {
      Row& row = rows[number];
      // The warm-up has the first turn, too.
      const std::size_t cpu = static_cast<std::size_t>(std::max(repeat, 0)) % turns.count();
      turns.on(cpu, [&] {
        // Before it is timed every row traces the rays once more: the row before it has filled the
        // caches with another structure, and what reading tens of megabytes anew takes would be
        // counted for the first row of each structure alone.
        if (repeat >= 0) trace_blocks(row, work, hits);
        row.counts = {};
        const double start = thread_cpu_seconds();
        trace_blocks(row, work, hits);
        if (repeat >= 0) add_run(row.cpu_seconds, cpu, thread_cpu_seconds() - start);
      });
      if (repeat < 0) compare(row, work, hits, first);
      if (repeat >= 0 && available_cpu_count() > 1) time_all_threads(row, work, hits);
    }
  }
  return first;
}

std::string report(const Workload& work, const std::vector<Row>& rows) {
  const auto rate = [&](const Row& row) {
    return 1e-6 * static_cast<double>(work.ray_count) / seconds_at_mean_speed(row.cpu_seconds);
  };
  double best_peer = 0;
  for (const Row& row : rows) {
    if (row.contender->is_reference_peer) best_peer = std::max(best_peer, rate(row));
  }
  std::printf("  %-22s %12s %10s %10s %10s %10s %10s %16s\n", ray_kind_name(work.kind),
              "Mrays/CPU-s", "to Embree", "all thr.", "CPU-s to 1", "hits", "differ", "sum of t");
  std::string list = "[";
  for (const Row& row : rows) {
    // Without a second processor there is nothing to compare.
    const bool has_all = !row.all_wall_seconds.empty();
    const double all_rate =
        has_all ? 1e-6 * static_cast<double>(work.ray_count) / median(row.all_wall_seconds)
                : std::nan("");
    const double to_one = has_all
                              ? seconds_at_mean_speed(row.cpu_seconds) / median(row.all_cpu_seconds)
                              : std::nan("");
    std::printf("  %-22s %12.2f %10.2f %10.2f %10.2f %10llu %10llu %16.9g\n",
                row.contender->name.c_str(), rate(row),
                best_peer > 0 ? rate(row) / best_peer : std::nan(""), all_rate, to_one,
                static_cast<unsigned long long>(row.hits),
                static_cast<unsigned long long>(row.different), row.sum_t);
    JsonObject json;
    json.add("name", row.contender->name).add("mrays_per_cpu_second", rate(row));
    if (has_all)
      json.add("mrays_all_threads", all_rate).add("per_cpu_second_to_one_thread", to_one);
    json.add("hits", row.hits).add("differ", row.different).add("sum_t", row.sum_t);
    list += (list.size() > 1 ? "," : "") + json.text();
  }
  JsonObject json;
  json.add("kind", std::string(ray_kind_name(work.kind))).add("rays", work.ray_count);
  json.add_raw("rows", list + "]");
  return json.text();
}

// Prints the steps per ray of the rows that counted some.
void report_counts(const Workload& work, const std::vector<Row>& rows) {
  bool has_head = false;
  for (const Row& row : rows) {
    const core::KernelCounts& c = row.counts;
    if (c.nodes == 0) continue;
    if (!has_head) {
      std::printf("  %-22s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n", "steps per ray", "packets",
                  "singles", "nodes", "children", "blocks", "triangles", "row tests", "with t",
                  "exact");
    }
    has_head = true;
    std::printf("  %-22s", row.contender->name.c_str());
    for (const std::uint64_t n : {c.packets, c.singles, c.nodes, c.children, c.blocks, c.candidates,
                                  c.row_tests, c.times, c.exact}) {
      std::printf(" %9.4f", static_cast<double>(n) / static_cast<double>(work.ray_count));
    }
    std::printf("\n");
  }
}

std::string report_builds(const std::vector<Build>& builds) {
  std::string list = "[";
  for (const Build& build : builds) {
    std::printf("  build %-16s %12.0f ms %23.1f MB\n", build.name.c_str(), 1e3 * build.cpu_seconds,
                build.megabytes);
    JsonObject json;
    json.add("name", build.name).add("cpu_seconds", build.cpu_seconds).add("mb", build.megabytes);
    list += (list.size() > 1 ? "," : "") + json.text();
  }
  return list + "]";
}

// Prints what steps cost, for the rows that counted some.
void report_costs(const std::vector<Row>& rows) {
  bool has_head = false;
  for (const Row& row : rows) {
    if (row.costs.is_empty()) continue;
    if (!has_head) std::printf("  %-22s", "cycles each (% of all)");
    for (const char* const name : CostFit::kNames) {
      if (!has_head) std::printf(" %12s", name);
    }
    if (!has_head) std::printf("\n");
    has_head = true;
    const CostFit::Costs costs = row.costs.fit(), shares = row.costs.shares(costs);
    std::printf("  %-22s", row.contender->name.c_str());
    for (std::size_t i = 0; i < costs.size(); ++i) {
      if (costs[i] > 0) {
        std::printf(" %6.0f (%2.0f%%)", costs[i], 100 * shares[i]);
      } else {
        std::printf(" %12s", "-");
      }
    }
    std::printf("\n");
  }
}

using AllEntrants = std::vector<std::unique_ptr<Entrants>>;

AllEntrants entrants_of(const Scene& scene, const core::TriangleStore& triangles,
                        const std::vector<Bounds3f>& boxes, const CoreSuiteOptions& options) {
  AllEntrants entrants;
  const bool is_instanced = scene.instances.size() > 1;
  entrants.push_back(make_ours(triangles, boxes, options.isa, {!is_instanced, options.with_sizes}));
  if (is_instanced) {
    entrants.push_back(make_ours_instanced(scene, options.isa));
    auto embree = make_embree_instanced(scene, options.isa);
    if (embree) entrants.push_back(std::move(embree));
    return entrants;
  }
  for (const bool is_high : {false, true}) {
    for (const bool is_robust : {false, true}) {
      if ((is_high || is_robust) && !options.with_all_peers) continue;
      auto embree = make_embree(triangles, options.isa, {is_high, is_robust});
      if (embree) entrants.push_back(std::move(embree));
    }
  }
  if (entrants.size() == 1)
    std::printf("Embree is not part of this build: install libembree-dev for the comparison\n");
  return entrants;
}

Scene whole_scene(const BenchScene& scene) {
  if (scene.instances.empty()) return test::make_scene(scene.mesh);
  Scene whole = test::make_scene(scene.meshes[0]);
  for (std::size_t m = 1; m < scene.meshes.size(); ++m) {
    whole.meshes.push_back(std::make_shared<const Mesh>(scene.meshes[m]));
  }
  whole.instances = scene.instances;
  return whole;
}

std::string run_scene(const BenchScene& scene, const CoreSuiteOptions& options) {
  std::vector<Bounds3f> boxes;
  const Scene whole = whole_scene(scene);
  const core::TriangleStore triangles = core::make_triangle_store(whole, boxes);
  const AllEntrants entrants = entrants_of(whole, triangles, boxes, options);
  std::printf("\n%s, %llu triangles\n", scene.name.c_str(),
              static_cast<unsigned long long>(whole.triangle_count()));
  const auto run = [&](const Workload& work, std::string& list) {
    std::vector<Row> rows;
    for (const auto& entrant : entrants) {
      for (const Contender& contender : entrant->contenders) {
        const bool is_wanted =
            rows.empty() || contender.name.find(options.only) != std::string::npos;
        if (contender.kind == work.kind && is_wanted) rows.push_back({&contender});
      }
    }
    const std::vector<FirstHit> first = measure(rows, work, options.repeats);
    list += (list.size() > 1 ? "," : "") + report(work, rows);
    report_counts(work, rows);
    report_costs(rows);
    return first;
  };
  const auto is_wanted = [&](RayKind kind) {
    const auto& kinds = options.kinds;
    return kinds.empty() ||
           std::find(kinds.begin(), kinds.end(), ray_kind_name(kind)) != kinds.end();
  };
  std::string list = "[";
  const Workload primary = primary_rays(scene.camera, options.size_px);
  std::vector<FirstHit> first;
  if (is_wanted(RayKind::kPrimary)) {
    first = run(primary, list);
  } else {
    std::vector<Row> rows{{&entrants[0]->contenders[0]}};
    first = measure(rows, primary, 0);
  }
  const SecondaryRays secondary = secondary_rays(primary, first, triangles, scene.light);
  if (is_wanted(RayKind::kShadow)) run(secondary.shadow, list);
  if (is_wanted(RayKind::kBounce)) run(secondary.bounce, list);
  std::vector<Build> builds;
  for (const auto& entrant : entrants)
    builds.insert(builds.end(), entrant->builds.begin(), entrant->builds.end());
  JsonObject json;
  json.add("scene", scene.name).add_raw("rays", list + "]");
  json.add_raw("builds", report_builds(builds));
  return json.text();
}

}  // namespace

Status run_core_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  for (const std::string& name : options.scenes) {
    std::fprintf(stderr, "making %s\n", name.c_str());
    auto scene = make_scene(name);
    if (!scene.is_ok()) return scene.status();
    json.push_back(run_scene(*scene, options));
  }
  return Status::ok();
}

}  // namespace tessera::bench
