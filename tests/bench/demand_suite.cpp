// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/demand_suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "common/base/json.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/bench/contender.h"
#include "tests/bench/scenes.h"
#include "tests/bench/workload.h"
#include "tests/support/test_meshes.h"

namespace tessera::bench {
namespace {

// The scene's triangles by the cells of a grid that their centroids lie in, a mesh for each cell.
Scene split(const Mesh& whole, float cell) {
  std::map<std::array<int, 3>, Mesh> parts;
  std::map<std::array<int, 3>, std::map<std::uint32_t, std::uint32_t>> numbers;
  for (const auto& triangle : whole.triangles) {
    Vec3f sum;
    for (const std::uint32_t v : triangle) sum = sum + whole.positions[v];
    const auto at = [cell](float x) { return static_cast<int>(std::floor(x / (3 * cell))); };
    const std::array<int, 3> key{at(sum.x), at(sum.y), at(sum.z)};
    Mesh& part = parts[key];
    std::array<std::uint32_t, 3> moved{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [entry, is_new] =
          numbers[key].try_emplace(triangle[k], static_cast<std::uint32_t>(part.positions.size()));
      if (is_new) part.positions.push_back(whole.positions[triangle[k]]);
      moved[k] = entry->second;
    }
    part.triangles.push_back(moved);
  }
  Scene scene = test::make_scene(test::make_cube());
  scene.meshes.clear();
  scene.instances.clear();
  for (auto& [key, part] : parts) {
    part.materials = {0};
    scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), {}});
    scene.meshes.push_back(std::make_shared<const Mesh>(std::move(part)));
  }
  return scene;
}

struct FirstFrame {
  double cpu_seconds = 0, wall_seconds = 0, megabytes = 0;
  std::uint64_t built = 0, hits = 0;
};

// Builds the scene and traces camera rays, and rays from what they hit to the light.
Result<FirstFrame> first_frame(const Scene& scene, const BenchScene& view, bool is_on_demand,
                               core::Instancing instancing, const CoreSuiteOptions& options) {
  const double cpu = process_cpu_seconds(), wall = wall_seconds();
  core::BuildOptions build;
  build.is_on_demand = is_on_demand;
  build.instancing = instancing;
  auto prepared = core::PreparedScene::build(scene, build);
  if (!prepared.is_ok()) return prepared.status();
  FirstFrame frame;
  const Workload primary = primary_rays(view.camera, options.size_px / 2);
  std::vector<core::CastRay> rays, shadows;
  for (const RayBlock& block : primary.blocks) {
    for (int i = 0; i < block.count; ++i) {
      rays.push_back({{block.origin[0][i], block.origin[1][i], block.origin[2][i]},
                      {block.direction[0][i], block.direction[1][i], block.direction[2][i]},
                      0,
                      block.t_max[i]});
    }
  }
  std::vector<core::CastHit> hits(rays.size());
  core::cast_rays(**prepared, rays, {options.isa, 64, 1, false}, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i].is_hit) continue;
    ++frame.hits;
    const Vec3f at = rays[i].origin + rays[i].direction * (0.9999f * hits[i].t);
    shadows.push_back({at, view.light - at, 0, 1});
  }
  std::vector<core::CastHit> blocked(shadows.size());
  core::cast_rays(**prepared, shadows, {options.isa, 64, 1, true}, blocked);
  for (const core::CastHit& hit : blocked) frame.hits += hit.is_hit ? 1 : 0;
  frame.cpu_seconds = process_cpu_seconds() - cpu;
  frame.wall_seconds = wall_seconds() - wall;
  frame.megabytes = 1e-6 * static_cast<double>((*prepared)->memory_bytes());
  frame.built = (*prepared)->built_primitives();
  return frame;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

Status run_demand_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  auto view = make_scene(options.is_quick ? "interior" : "building");
  if (!view.is_ok()) return view.status();
  Bounds3f bounds;
  for (const Vec3f p : view->mesh.positions) bounds.grow(p);
  const Vec3f e = bounds.extent();
  const Scene scene = split(view->mesh, std::max({e.x, e.y, e.z}) / 16);
  std::printf("\n%s in %zu objects, first frame\n", view->name.c_str(), scene.meshes.size());
  std::printf("  %-12s %12s %10s %10s %12s\n", "", "CPU-ms", "ms", "MB", "built");
  struct Way {
    const char* name;
    bool is_on_demand;
    core::Instancing instancing;
    std::vector<double> cpu{}, wall{};
    FirstFrame last{};
  };
  Way ways[] = {{"flattened", false, core::Instancing::kNever},
                {"objects", false, core::Instancing::kAlways},
                {"on demand", true, core::Instancing::kAuto}};
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (Way& way : ways) {
      auto frame = first_frame(scene, *view, way.is_on_demand, way.instancing, options);
      if (!frame.is_ok()) return frame.status();
      if (frame->hits != ways[0].last.hits && ways[0].last.hits != 0)
        return Status::internal(std::string(way.name) + ": rays are answered otherwise");
      way.cpu.push_back(frame->cpu_seconds);
      way.wall.push_back(frame->wall_seconds);
      way.last = *frame;
    }
  }
  for (const Way& way : ways) {
    std::printf("  %-12s %12.1f %10.1f %10.1f %12llu\n", way.name, 1e3 * median(way.cpu),
                1e3 * median(way.wall), way.last.megabytes,
                static_cast<unsigned long long>(way.last.built));
    JsonObject row;
    row.add("scene", view->name).add("objects", static_cast<std::uint64_t>(scene.meshes.size()));
    row.add("name", way.name).add("cpu_seconds", median(way.cpu));
    row.add("wall_seconds", median(way.wall)).add("mb", way.last.megabytes);
    json.push_back(row.add("built", way.last.built).text());
  }
  return Status::ok();
}

}  // namespace tessera::bench
