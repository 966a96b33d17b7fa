// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/thesis_suite.h"

#include <cstdio>
#include <functional>

#include "common/base/cpu_count.h"
#include "common/base/json.h"
#include "slave/core/accel/kd_builder.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "tests/bench/scenes.h"
#include "tests/bench/thesis_tracer.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

constexpr int kEdgePx = 4;  // the thesis's bundle
constexpr int kTilePx = 64, kSubtilePx = 16;

// The thesis's figures for a scene; 0: it has none.
struct ThesisFigures {
  const char* scene;
  const char* name;
  double steps, tests, steps_extremal, tests_extremal;
  double entry_steps, steps_entered, tests_entered, steps_extremal_entered, tests_extremal_entered;
  double tests_repeated, tests_once, hashed[4];
  double by_distance, inside, full, full_without;
};
constexpr ThesisFigures kThesis[] = {
    {"interior",
     "Conference",
     39.65,
     6.03,
     42.13,
     7.93,
     3.37,
     20.46,
     6.04,
     22.99,
     7.94,
     6.99,
     5.97,
     {6.14, 6.06, 6.03, 6.00},
     17.99,
     61.98,
     20.03,
     26.26},
    {"knot",
     "VW Beetle",
     36.81,
     5.61,
     42.01,
     7.06,
     3.56,
     25.03,
     5.61,
     30.26,
     7.16,
     8.17,
     5.45,
     {6.02, 5.77, 5.61, 5.52},
     13.05,
     68.90,
     18.05,
     20.64},
    {"building",
     "Soda Hall",
     29.64,
     3.68,
     30.08,
     5.01,
     2.94,
     23.27,
     4.24,
     23.89,
     5.60,
     4.25,
     3.68,
     {3.79, 3.76, 3.73, 3.72},
     19.30,
     52.32,
     28.38,
     32.76},
};
// Table 4.1, VW Beetle: 1, 2x2 .. 32x32 rays.
constexpr double kThesisSizes[5][6] = {{29.79, 32.25, 36.81, 56.33, 104.32, 261.23},
                                       {2.73, 3.59, 5.61, 11.68, 29.34, 88.50},
                                       {36.39, 35.80, 34.66, 31.97, 27.34, 22.68},
                                       {39.08, 38.22, 36.01, 31.65, 25.23, 19.22},
                                       {24.53, 25.97, 29.33, 36.39, 47.43, 58.10}};

struct Table {
  const core::TriangleStore& triangles;
  const core::KdTree& tree;
  core::CameraRays camera;
  int size_px;

  ThesisCounts trace(Way way, int edge_px, bool is_entered, bool with_details) const {
    ThesisTracer tracer(tree, triangles, camera);
    ThesisCounts counts;
    const Subtree root = tracer.root();
    std::uint64_t steps = 0;
    for_tiles(kTilePx, {0, 0}, size_px, [&](int x, int y) {
      const Subtree tile = is_entered ? tracer.find_entry(x, y, kTilePx, root, steps) : root;
      for_tiles(kSubtilePx, {x, y}, kTilePx, [&](int sx, int sy) {
        const Subtree entry =
            is_entered ? tracer.find_entry(sx, sy, kSubtilePx, tile, steps) : root;
        for_tiles(edge_px, {sx, sy}, kSubtilePx, [&](int bx, int by) {
          tracer.trace(way, bx, by, edge_px, entry, with_details, counts);
        });
      });
    });
    return counts;
  }

  // Counts of bundles that have more pixels than a subtile.
  ThesisCounts trace_large(int edge_px) const {
    ThesisTracer tracer(tree, triangles, camera);
    ThesisCounts counts;
    for_tiles(edge_px, {0, 0}, size_px, [&](int x, int y) {
      tracer.trace(Way::kMasked, x, y, edge_px, tracer.root(), false, counts);
    });
    return counts;
  }

  struct EntryCounts {
    std::uint64_t tiles = 0, subtiles = 0, tile_steps = 0, subtile_steps = 0;
  };
  EntryCounts entries() const {
    ThesisTracer tracer(tree, triangles, camera);
    EntryCounts counts;
    for_tiles(kTilePx, {0, 0}, size_px, [&](int x, int y) {
      const Subtree tile = tracer.find_entry(x, y, kTilePx, tracer.root(), counts.tile_steps);
      ++counts.tiles;
      for_tiles(kSubtilePx, {x, y}, kTilePx, [&](int sx, int sy) {
        tracer.find_entry(sx, sy, kSubtilePx, tile, counts.subtile_steps);
        ++counts.subtiles;
      });
    });
    return counts;
  }

 private:
  struct Pixel {
    int x, y;
  };
  template <typename Do>
  static void for_tiles(int edge, Pixel at, int size, const Do& do_tile) {
    for (int y = 0; y < size; y += edge) {
      for (int x = 0; x < size; x += edge) do_tile(at.x + x, at.y + y);
    }
  }
};

double per(std::uint64_t n, std::uint64_t of) {
  return of == 0 ? 0 : static_cast<double>(n) / static_cast<double>(of);
}
double percent(std::uint64_t n, std::uint64_t of) { return 100 * per(n, of); }

// Prints lines of a table, our figure and the thesis's where it has one, and keeps them as JSON.
class Lines {
 public:
  void add(const std::string& name, double here, double thesis) {
    std::printf("    %-58s %9.2f", name.c_str(), here);
    if (thesis > 0) std::printf(" %9.2f", thesis);
    std::printf("\n");
    keep(name, here, thesis);
  }
  void keep(const std::string& name, double here, double thesis) {
    JsonObject line;
    line.add("name", name).add("here", here);
    if (thesis > 0) line.add("thesis", thesis);
    list_ += (list_.empty() ? "" : ",") + line.text();
  }
  std::string json() const { return "[" + list_ + "]"; }

 private:
  std::string list_;
};

void print_sizes(const Table& table, Lines& lines) {
  constexpr int kEdges[] = {1, 2, 4, 8, 16, 32};
  std::printf("  table 4.1, bundles of %36s", "");
  for (const int edge : kEdges) std::printf(" %4dx%-4d", edge, edge);
  std::printf("\n");
  ThesisCounts counts[6];
  for (int i = 0; i < 6; ++i) counts[i] = table.trace_large(kEdges[i]);
  const auto row = [&](const char* name, const auto& value, const double* thesis) {
    std::printf("    %-58s", name);
    for (int i = 0; i < 6; ++i) {
      std::printf(" %9.2f", value(counts[i]));
      const std::string edge = std::to_string(kEdges[i]);
      lines.keep(edge + "x" + edge + ": " + name, value(counts[i]), thesis ? thesis[i] : 0);
    }
    if (thesis != nullptr) {
      std::printf("\n    %-58s", "  thesis, VW Beetle");
      for (int i = 0; i < 6; ++i) std::printf(" %9.2f", thesis[i]);
    }
    std::printf("\n");
  };
  using Counts = ThesisCounts;
  row(
      "steps / bundle", [](const Counts& c) { return per(c.steps, c.bundles); }, kThesisSizes[0]);
  row(
      "tests / bundle", [](const Counts& c) { return per(c.tests_once, c.bundles); },
      kThesisSizes[1]);
  row(
      "front child only, %", [](const Counts& c) { return percent(c.front_only, c.steps); },
      kThesisSizes[2]);
  row(
      "back child only, %", [](const Counts& c) { return percent(c.back_only, c.steps); },
      kThesisSizes[3]);
  row(
      "both children, %", [](const Counts& c) { return percent(c.both, c.steps); },
      kThesisSizes[4]);
}

void print_ways(const Table& table, const ThesisFigures& thesis, Lines& lines) {
  std::printf("  tables 4.2 and 4.3, bundles of 4x4%27s %9s %9s\n", "", "here", thesis.name);
  const ThesisCounts masked = table.trace(Way::kMasked, kEdgePx, false, false);
  const ThesisCounts extremal = table.trace(Way::kExtremal, kEdgePx, false, false);
  const ThesisCounts segment = table.trace(Way::kOneSegment, kEdgePx, false, false);
  const ThesisCounts entered = table.trace(Way::kMasked, kEdgePx, true, false);
  const ThesisCounts both = table.trace(Way::kExtremal, kEdgePx, true, false);
  const Table::EntryCounts entry = table.entries();
  const auto add = [&](const char* name, const ThesisCounts& c, double steps, double tests) {
    lines.add(std::string("steps / bundle, ") + name, per(c.steps, c.bundles), steps);
    lines.add(std::string("tests / bundle, ") + name, per(c.tests_once, c.bundles), tests);
  };
  add("masked", masked, thesis.steps, thesis.tests);
  add("extremal", extremal, thesis.steps_extremal, thesis.tests_extremal);
  add("one segment (figure 4.15)", segment, 0, 0);
  add("masked, from entry points", entered, thesis.steps_entered, thesis.tests_entered);
  add("extremal, from entry points", both, thesis.steps_extremal_entered,
      thesis.tests_extremal_entered);
  lines.add("steps saved by entry points, masked, %", 100 - percent(entered.steps, masked.steps),
            thesis.steps > 0 ? 100 - 100 * thesis.steps_entered / thesis.steps : 0);
  lines.add("steps to find entry points / bundle",
            per(entry.tile_steps + entry.subtile_steps, entered.bundles), thesis.entry_steps);
  const bool is_conference = std::string(thesis.scene) == "interior";
  lines.add("steps / tile of 64x64", per(entry.tile_steps, entry.tiles), is_conference ? 62.24 : 0);
  lines.add("steps / tile of 16x16", per(entry.subtile_steps, entry.subtiles),
            is_conference ? 40.76 : 0);
}

void print_tests(const Table& table, const ThesisFigures& thesis, Lines& lines) {
  const ThesisCounts c = table.trace(Way::kMasked, kEdgePx, false, true);
  std::printf("  tables 4.4 and 4.5, mailboxes%32s %9s %9s\n", "", "here", thesis.name);
  lines.add("tests / bundle, none", per(c.tests, c.bundles), thesis.tests_repeated);
  lines.add("tests / bundle, one for each triangle", per(c.tests_once, c.bundles),
            thesis.tests_once);
  for (std::size_t i = 0; i < kMailboxSizes.size(); ++i) {
    const std::string name =
        "tests / bundle, hashed, " + std::to_string(kMailboxSizes[i]) + " entries";
    lines.add(name, per(c.tests_hashed[i], c.bundles), thesis.hashed[i]);
  }
  std::printf("  tables 5.1 and 5.2, tests of four rays%23s %9s %9s\n", "", "here", thesis.name);
  const std::uint64_t ends = c.exit_by_distance + c.exit_inside + c.full;
  lines.add("end by distance, %", percent(c.exit_by_distance, ends), thesis.by_distance);
  lines.add("end by the inside test, %", percent(c.exit_inside, ends), thesis.inside);
  lines.add("full test, %", percent(c.full, ends), thesis.full);
  lines.add("full test without the distance test, %", percent(c.full_without_distance, ends),
            thesis.full_without);
  lines.add("wrong, projection test, per million rays tested",
            1e6 * per(c.projection_errors, c.decisions), 0);
  lines.add("wrong, Pluecker test, per million rays tested",
            1e6 * per(c.pluecker_errors, c.decisions), 0);
  std::printf("  what else could be saved%37s %9s\n", "", "here");
  lines.add("tests in leaves whose triangles' box is missed, %",
            percent(c.tests_outside_box, c.tests), 0);
  lines.add("edges to test, if once per leaf, % of three per triangle",
            percent(c.edges, 3 * c.tests), 0);
  std::printf("  section 5.3, memory touched by a frame, MB%19s %9s %9s\n", "", "here",
              thesis.name);
  lines.add("nodes, 8 bytes a step", 8e-6 * static_cast<double>(c.steps),
            8e-6 * 65536 * thesis.steps);
  lines.add("triangles, 48 bytes a test", 48e-6 * static_cast<double>(c.tests_once),
            48e-6 * 65536 * thesis.tests);
}

std::string run_tree(const char* name, const core::KdBuildConfig& config, const BenchScene& scene,
                     const core::TriangleStore& triangles, const std::vector<Bounds3f>& boxes,
                     int size_px) {
  std::fprintf(stderr, "building the %s tree\n", name);
  const auto tree = core::build_kd_tree(boxes, {available_cpu_count(), nullptr}, config);
  if (!tree.is_ok()) return "{}";
  std::printf("\n%s, %s tree: %zu nodes, %.2f references per triangle\n", scene.name.c_str(), name,
              tree->nodes().size(),
              static_cast<double>(tree->primitive_refs().size()) /
                  static_cast<double>(triangles.primitive_count()));
  const ThesisFigures none{scene.name.c_str(), "", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {}, 0, 0, 0, 0};
  const ThesisFigures* thesis = &none;
  for (const ThesisFigures& figures : kThesis) {
    if (scene.name == figures.scene) thesis = &figures;
  }
  const Table table{triangles, *tree, core::CameraRays(scene.camera, size_px, size_px), size_px};
  Lines lines;
  print_sizes(table, lines);
  print_ways(table, *thesis, lines);
  print_tests(table, *thesis, lines);
  JsonObject json;
  json.add("scene", scene.name).add("tree", std::string(name)).add_raw("lines", lines.json());
  return json.text();
}

}  // namespace

Status run_thesis_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  for (const std::string& name : options.scenes) {
    if (name == "field") continue;  // the thesis has nothing like it
    std::fprintf(stderr, "making %s\n", name.c_str());
    auto scene = make_scene(name);
    if (!scene.is_ok()) return scene.status();
    std::vector<Bounds3f> boxes;
    const core::TriangleStore triangles =
        core::make_triangle_store(test::make_scene(scene->mesh), boxes);
    const core::TriangleClipper clipper(triangles.vertices);
    core::KdBuildConfig fine = core::quality_build(clipper);
    fine.cost_intersect = 2;
    fine.refs_per_primitive_max = 30;
    json.push_back(run_tree("fine", fine, *scene, triangles, boxes, options.size_px));
    json.push_back(run_tree("coarse", {}, *scene, triangles, boxes, options.size_px));
  }
  return Status::ok();
}

}  // namespace tessera::bench
