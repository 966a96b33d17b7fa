// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/build_suite.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "common/base/cpu_count.h"
#include "common/base/json.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "tests/bench/contender.h"
#include "tests/bench/cpu_turns.h"
#include "tests/bench/scenes.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

struct Input {
  core::TriangleStore triangles;
  std::vector<Bounds3f> boxes;
};

// Builds with so many threads.
using BuildOnce = std::function<Build(int threads)>;

struct Row {
  std::string name;
  int threads;
  BuildOnce build;
  bool is_reference;
  // Of each processor that one thread has run on, in turn; of several threads there is one list.
  std::vector<std::vector<double>> wall_seconds{}, cpu_seconds{};
  double megabytes = 0;
  std::uint64_t faults = 0;  // pages touched for the first time, of the last run
};

// What a first touch of memory costs is the system's affair, and on virtual machines differs from
// one second to the next. The heap takes more than a build needs at once, for it has to find room
// between what the last one left.
void keep_memory(std::size_t triangles) {
  constexpr std::size_t kBytesPerTriangle = 256, kPage = 4096;
  (void)mallopt(M_MMAP_MAX, 0);
  (void)mallopt(M_TRIM_THRESHOLD, -1);
  const std::size_t bytes = triangles * kBytesPerTriangle;
  auto* const pages = static_cast<volatile char*>(std::malloc(bytes));
  for (std::size_t at = 0; pages != nullptr && at < bytes; at += kPage) pages[at] = 1;
  std::free(const_cast<char*>(pages));
}

std::uint64_t page_faults() {
  rusage used{};
  (void)getrusage(RUSAGE_SELF, &used);
  return static_cast<std::uint64_t>(used.ru_minflt);
}

template <typename BuildIndex>
Build timed(const BuildIndex& build) {
  const double wall = wall_seconds(), cpu = process_cpu_seconds();
  const auto index = build();
  return {"", process_cpu_seconds() - cpu, wall_seconds() - wall,
          1e-6 * static_cast<double>(index->memory_bytes())};
}

template <int W>
void add_ours(const Input& input, int threads, std::vector<Row>& rows) {
  const std::string width = std::to_string(W);
  const auto bvh = [&input](int n) {
    return timed([&] {
      const core::TriangleClipper clipper(input.triangles.vertices);
      return core::index_by_bvh<W>(input.boxes, input.triangles.vertices, {n, nullptr},
                                   core::usual_build(clipper));
    });
  };
  const auto spatial = [&input](int n) {
    return timed([&] {
      const core::TriangleClipper clipper(input.triangles.vertices);
      return core::index_by_bvh<W>(input.boxes, input.triangles.vertices, {n, nullptr},
                                   core::spatial_build(clipper));
    });
  };
  const auto kd = [&input](int n) {
    return timed([&] {
      return core::index_by_kd<W>(input.boxes, input.triangles.vertices, {n, nullptr});
    });
  };
  rows.push_back({"bvh" + width, threads, bvh, false});
  rows.push_back({"bvh" + width + " quality", threads, spatial, false});
  const auto quality = [&input](int n) {
    return timed([&] {
      const core::TriangleClipper clipper(input.triangles.vertices);
      return core::index_by_kd<W>(input.boxes, input.triangles.vertices, {n, nullptr},
                                  core::quality_build(clipper));
    });
  };
  rows.push_back({"kd" + width, threads, kd, false});
  rows.push_back({"kd" + width + " quality", threads, quality, false});
}

std::vector<Row> rows_of(const Input& input, const CoreSuiteOptions& options) {
  std::vector<Row> rows;
  const int cpus = available_cpu_count();
  for (int threads = 1; threads <= cpus; threads *= 2) {
    if (core::kernels_for(options.isa).lane_count >= 16) {
      add_ours<16>(input, threads, rows);
    } else {
      add_ours<8>(input, threads, rows);
    }
    for (const bool is_high : {false, true}) {
      if (!has_embree() || (is_high && !options.with_all_peers)) continue;
      const Isa isa = options.isa;
      rows.push_back({is_high ? "embree high" : "embree medium", threads,
                      [&input, isa, is_high](int n) {
                        return build_embree(input.triangles, isa, {is_high, false}, n);
                      },
                      !is_high});
    }
  }
  std::erase_if(rows, [&options](const Row& row) {
    return !row.is_reference && row.name.find(options.only) == std::string::npos;
  });
  return rows;
}

// Prints a table. Its ratios are of rates: CPU-seconds of Embree's medium build with as many
// threads, over those of the row. One thread is timed on each processor in turn, as two threads run
// on two of them.
std::string report(const std::vector<Row>& rows) {
  std::printf("  %-16s %8s %10s %10s %12s %12s %9s %9s\n", "", "threads", "ms", "CPU-ms",
              "to embree", "to 1 thread", "MB", "faults");
  std::string list = "[";
  for (const Row& row : rows) {
    double peer = 0, one = 0;
    for (const Row& other : rows) {
      if (other.is_reference && other.threads == row.threads)
        peer = seconds_at_mean_speed(other.cpu_seconds);
      if (other.name == row.name && other.threads == 1)
        one = seconds_at_mean_speed(other.wall_seconds);
    }
    const double wall = seconds_at_mean_speed(row.wall_seconds);
    const double cpu = seconds_at_mean_speed(row.cpu_seconds);
    std::printf("  %-16s %8d %10.0f %10.0f %12.2f %12.2f %9.1f %9llu\n", row.name.c_str(),
                row.threads, 1e3 * wall, 1e3 * cpu, peer / cpu, one / wall, row.megabytes,
                static_cast<unsigned long long>(row.faults));
    JsonObject json;
    json.add("name", row.name).add("threads", static_cast<std::uint64_t>(row.threads));
    json.add("wall_seconds", wall).add("cpu_seconds", cpu).add("mb", row.megabytes);
    json.add("page_faults", row.faults);
    list += (list.size() > 1 ? "," : "") + json.text();
  }
  return list + "]";
}

// Takes every step-th triangle, for a scene of the same extent with fewer of them.
Input every(const Input& all, std::size_t step) {
  Input some;
  std::vector<float> vertices;
  for (std::size_t t = 0; t < all.boxes.size(); t += step) {
    const float* const corners = all.triangles.vertices.data() + 9 * t;
    vertices.insert(vertices.end(), corners, corners + 9);
    some.boxes.push_back(all.boxes[t]);
  }
  some.triangles.keep(std::move(vertices));
  some.triangles.instance_first = {0, some.boxes.size()};
  return some;
}

void run_once(Row& row, std::size_t cpu, bool is_to_warm_up) {
  const std::uint64_t faults = page_faults();
  const Build build = row.build(row.threads);
  row.faults = page_faults() - faults;
  row.megabytes = build.megabytes;
  if (is_to_warm_up) return;
  add_run(row.wall_seconds, cpu, build.wall_seconds);
  add_run(row.cpu_seconds, cpu, build.cpu_seconds);
}

std::string run_input(const std::string& name, const Input& input,
                      const CoreSuiteOptions& options) {
  std::vector<Row> rows = rows_of(input, options);
  const CpuTurns turns;
  for (int repeat = -1; repeat < options.repeats; ++repeat) {
    for (Row& row : rows) {
      // Warm without turns: a library may count its processors when it first builds.
      if (row.threads > 1 || repeat < 0) {
        run_once(row, 0, repeat < 0);
      } else {
        for (std::size_t cpu = 0; cpu < turns.count(); ++cpu)
          turns.on(cpu, [&] { run_once(row, cpu, false); });
      }
    }
  }
  std::printf("\n%s, %zu triangles, builds\n", name.c_str(), input.boxes.size());
  JsonObject json;
  json.add("scene", name).add("triangles", static_cast<std::uint64_t>(input.boxes.size()));
  return json.add_raw("builds", report(rows)).text();
}

}  // namespace

Status run_build_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  for (const std::string& name : options.scenes) {
    std::fprintf(stderr, "making %s\n", name.c_str());
    auto scene = make_scene(name);
    if (!scene.is_ok()) return scene.status();
    Input input;
    input.triangles = core::make_triangle_store(test::make_scene(scene->mesh), input.boxes);
    if (options.keeps_memory) keep_memory(input.boxes.size());
    if (options.with_sizes) {
      for (const std::size_t step : {256, 64, 16, 4})
        json.push_back(run_input(name, every(input, step), options));
    }
    json.push_back(run_input(name, input, options));
  }
  return Status::ok();
}

}  // namespace tessera::bench
