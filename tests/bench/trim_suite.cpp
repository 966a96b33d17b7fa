// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/trim_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "common/base/json.h"
#include "slave/core/primitive/patch/trim_set.h"
#include "tests/bench/contender.h"
#include "tests/bench/trim_tree.h"
#include "tests/support/trim_shapes.h"

namespace tessera::bench {
namespace {

using core::TrimSteps;

enum class Layout { kBeside, kNested, kStrips };
constexpr const char* kLayoutNames[] = {"beside", "nested", "strips"};

PatchSurface surface_of(Layout layout, int loops) {
  PatchSurface surface = test::plain_patch(true);
  const int side = static_cast<int>(std::ceil(std::sqrt(loops)));
  for (int i = 0; i < loops; ++i) {
    const float cell = 1 / static_cast<float>(layout == Layout::kBeside ? side : loops);
    const auto at = [&](int place) { return (static_cast<float>(place) + 0.5f) * cell; };
    if (layout == Layout::kBeside) {
      test::add_circle(surface, at(i % side), at(i / side), 0.3f * cell);
    } else if (layout == Layout::kNested) {
      test::add_circle(surface, 0.5f, 0.5f, 0.5f * at(i));
    } else {
      test::add_rectangle(surface, at(i) - 0.3f * cell, 0.1f, at(i) + 0.3f * cell, 0.9f);
    }
  }
  return surface;
}

struct Way {
  const char* name;
  int asks;
  std::function<bool(const core::TrimPlace&, TrimSteps&)> is_kept;
  TrimSteps steps = {};
  int kept = 0, differing = 0;
  std::vector<double> seconds = {};
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string run_layout(Layout layout, int loops, int repeats) {
  const PatchSurface surface = surface_of(layout, loops);
  const double begun = process_cpu_seconds();
  const core::TrimSet set(surface);
  const double prepared = process_cpu_seconds() - begun;
  const core::TrimCells& cells = set.cells();
  const TrimTree tree(cells);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0, 1);
  std::vector<core::TrimPlace> places(100'000);
  for (core::TrimPlace& p : places) p = {anywhere(random), anywhere(random)};
  const auto by_all = [&](const core::TrimPlace& p, TrimSteps& steps) {
    bool is_odd = false;
    steps.pieces += cells.pieces.size();
    for (const core::TrimPiece& piece : cells.pieces)
      is_odd ^= core::crosses(piece, cells.coefficients.data(), p.u, p.v, steps.points);
    return !is_odd;
  };
  // The slower, the fewer points.
  Way ways[] = {
      {"cells", 100'000,
       [&](const core::TrimPlace& p, TrimSteps& s) { return set.is_kept(0, p.u, p.v, s); }},
      {"tree", loops > 100 ? 10'000 : 100'000,
       [&](const core::TrimPlace& p, TrimSteps& s) { return !tree.is_odd(p.u, p.v, s); }},
      {"linear", std::max(1'000, 100'000 / loops), by_all}};
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (Way& way : ways) {
      way.steps = {};
      way.kept = 0;
      const double start = process_cpu_seconds();
      for (int i = 0; i < way.asks; ++i)
        way.kept += way.is_kept(places[static_cast<std::size_t>(i)], way.steps);
      way.seconds.push_back(process_cpu_seconds() - start);
    }
  JsonObject json;
  json.add("layout", kLayoutNames[static_cast<int>(layout)]).add("loops", loops);
  json.add("cells_bytes_a_segment",
           static_cast<double>(set.loops().bytes()) / static_cast<double>(surface.degrees.size()));
  json.add("prepare_cpu_seconds", prepared);
  std::printf("  %8s %6d", kLayoutNames[static_cast<int>(layout)], loops);
  TrimSteps unused;
  for (Way& way : ways) {
    for (int i = 0; i < way.asks; ++i) {
      const core::TrimPlace& p = places[static_cast<std::size_t>(i)];
      way.differing += way.is_kept(p, unused) != ways[0].is_kept(p, unused);
    }
    const auto each = [&](double sum) { return sum / way.asks; };
    const double ns = 1e9 * each(median(way.seconds));
    JsonObject row;
    row.add("ns", ns).add("nodes", each(static_cast<double>(way.steps.cells)));
    row.add("pieces", each(static_cast<double>(way.steps.pieces)));
    row.add("points", each(static_cast<double>(way.steps.points)));
    json.add_raw(way.name, row.add("differing", way.differing).text());
    std::printf("  %9.1f %8.2f %6.2f", ns, each(static_cast<double>(way.steps.pieces)),
                each(static_cast<double>(way.steps.points)));
  }
  std::printf("  %6.0f\n", static_cast<double>(set.loops().bytes()) /
                               static_cast<double>(surface.degrees.size()));
  return json.text();
}

}  // namespace

Status run_trim_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  std::printf(
      "\nis a point kept: ns, pieces and points of pieces a query; bytes of cells a segment\n");
  std::printf("  %8s %6s  %25s  %25s  %25s  %6s\n", "layout", "loops", "cells", "tree", "linear",
              "bytes");
  for (const Layout layout : {Layout::kBeside, Layout::kNested, Layout::kStrips})
    for (const int loops : {1, 10, 100, 1000})
      json.push_back(run_layout(layout, loops, options.repeats));
  return Status::ok();
}

}  // namespace tessera::bench
