// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/deform_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "common/base/json.h"
#include "tests/bench/contender.h"
#include "tests/bench/deform_scene.h"
#include "tests/bench/scenes.h"
#include "tests/bench/workload.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

// Structures are built in the first frame and fitted to the others.
constexpr int kFrames = 25;
constexpr float kFramesPerSecond = 24;

// A scene of the suite "core" that sways.
Result<Deforming> swaying(const std::string& name) {
  auto made = make_scene(name);
  if (!made.is_ok()) return made.status();
  Bounds3f bounds;
  for (const Vec3f p : made->mesh.positions) bounds.grow(p);
  const Vec3f size = bounds.extent();
  const auto mesh = std::make_shared<const Mesh>(std::move(made->mesh));
  const auto at = [mesh, size](float t) {
    Mesh moved = *mesh;
    for (Vec3f& p : moved.positions) {
      const float phase = 9 * (p.x / size.x + p.y / size.y) + 2 * t;
      p.x += 0.02f * size.x * std::sin(phase);
      p.y += 0.02f * size.y * std::cos(1.3f * phase);
    }
    return test::make_scene(std::move(moved));
  };
  return Deforming{name, at, made->camera, made->light};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

using Times = std::map<std::string, std::vector<double>>;

// Rays per second through each structure, of the best way that each kind of rays has.
class RayRates {
 public:
  RayRates(const Deforming& scene, const core::TriangleStore& triangles, Entrants& ours, int size)
      : ours_(ours) {
    workloads_.push_back(primary_rays(scene.camera, size));
    std::vector<FirstHit> hits;
    BlockHits found;
    for (const RayBlock& block : workloads_[0].blocks) {
      ours.contenders[0].trace(block, found);
      for (int i = 0; i < block.count; ++i) hits.push_back({found.t[i], found.primitive[i]});
    }
    SecondaryRays secondary = secondary_rays(workloads_[0], hits, triangles, scene.light);
    workloads_.push_back(std::move(secondary.shadow));
    workloads_.push_back(std::move(secondary.bounce));
  }

  void run() {
    for (const Workload& work : workloads_) {
      for (const Contender& contender : ours_.contenders) {
        if (contender.kind != work.kind) continue;
        BlockHits found;
        const double start = thread_cpu_seconds();
        for (const RayBlock& block : work.blocks) contender.trace(block, found);
        seconds_[ray_kind_name(work.kind)][contender.name].push_back(thread_cpu_seconds() - start);
      }
    }
  }

  // Returns: the rate of rays of the kind in `structure` to that in "built", least of all ways.
  double to_built(const std::string& kind, const std::string& structure) const {
    double least = Bounds3f::kInf;
    const Times& times = seconds_.at(kind);
    for (const auto& [name, seconds] : times) {
      if (name.rfind("built ", 0) != 0) continue;
      std::vector<double> ratios;
      const std::vector<double>& others = times.at(structure + name.substr(5));
      for (std::size_t i = 0; i < seconds.size(); ++i) ratios.push_back(seconds[i] / others[i]);
      least = std::min(least, median(ratios));
    }
    return least;
  }

 private:
  Entrants& ours_;
  std::vector<Workload> workloads_;
  std::map<std::string, Times> seconds_;  // by kind of rays
};

Result<std::string> run_scene(const Deforming& scene, const CoreSuiteOptions& options) {
  std::vector<core::TriangleStore> frames;
  std::vector<Bounds3f> boxes;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Scene now = scene.at(static_cast<float>(frame) / kFramesPerSecond);
    frames.push_back(core::make_triangle_store(now, boxes));
    frames.back().meshes = {};
    frames.back().instances = {};
  }
  Times times;
  std::unique_ptr<Entrants> ours;
  for (int repeat = -1; repeat < options.repeats; ++repeat) {
    ours = make_ours_deformed(frames, boxes, options.isa);
    std::vector<Build> builds = ours->builds;
    if (has_embree()) {
      builds.push_back(build_embree(frames.back(), options.isa, {}, 1));
      builds.push_back(build_embree_low(frames.back(), options.isa));
      builds.push_back(refit_embree(frames[kFrames - 2], frames.back(), options.isa));
      builds[3].name = "embree medium";
    }
    if (repeat < 0) continue;
    for (const Build& build : builds) times[build.name].push_back(build.cpu_seconds);
  }
  RayRates rays(scene, frames.back(), *ours, options.size_px / 2);
  for (int repeat = 0; repeat < options.repeats; ++repeat) rays.run();
  std::printf("\n%s, %zu triangles\n", scene.name.c_str(), boxes.size());
  JsonObject json;
  json.add("scene", scene.name).add("triangles", static_cast<std::uint64_t>(boxes.size()));
  JsonObject cpu;
  for (const auto& [name, seconds] : times) {
    std::printf("  %-16s %10.1f CPU-ms\n", name.c_str(), 1e3 * median(seconds));
    cpu.add(name, median(seconds));
  }
  json.add_raw("cpu_seconds", cpu.text());
  for (const std::string structure : {"fast", "fitted"}) {
    JsonObject rates;
    for (int kind = 0; kind < kRayKinds; ++kind) {
      const std::string name = ray_kind_name(static_cast<RayKind>(kind));
      const double ratio = rays.to_built(name, structure);
      std::printf("  %-16s %10.2f of the rate of %s rays in built\n", structure.c_str(), ratio,
                  name.c_str());
      rates.add(name, ratio);
    }
    json.add_raw(structure + "_to_built", rates.text());
  }
  return json.text();
}

}  // namespace

Status run_deform_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  std::vector<Deforming> scenes = {waves()};
  if (!options.is_quick) {
    scenes.push_back(swell());
    for (const char* const name : {"interior", "knot"}) {
      Result<Deforming> scene = swaying(name);
      if (!scene.is_ok()) return scene.status();
      scenes.push_back(std::move(*scene));
    }
  }
  for (const Deforming& scene : scenes) {
    Result<std::string> row = run_scene(scene, options);
    if (!row.is_ok()) return row.status();
    json.push_back(std::move(*row));
  }
  return Status::ok();
}

}  // namespace tessera::bench
