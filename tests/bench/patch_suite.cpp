// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/patch_suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/base/json.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/bench/contender.h"
#include "tests/support/patch_scene_of.h"

namespace tessera::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Teapots in a cube of side^3, all of them turned alike, as a surface of patches in world space.
Scene teapots(int side) {
  Scene scene = test::patch_scene_of("teapot");
  scene.instances.clear();
  for (int i = 0; i < side * side * side; ++i) {
    Transform t;
    const int at[3] = {i % side, i / side % side, i / side / side};
    constexpr float kApart[3] = {7, 5, 4};
    for (std::size_t a = 0; a < 3; ++a) t.m[a][3] = kApart[a] * static_cast<float>(at[a]);
    scene.instances.push_back({0, t, ObjectKind::kPatchSurface});
  }
  return scene;
}

// All patches of the store as triangles, cells x cells squares of two each.
Scene tessellated(const core::PatchStore& patches, int cells) {
  Mesh mesh;
  mesh.materials = {0};
  const auto corners = static_cast<std::uint32_t>(cells + 1);
  for (const core::Patch& patch : patches.patches) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t i = 0; i < corners; ++i) {
      for (std::uint32_t j = 0; j < corners; ++j) {
        const core::PatchJet jet =
            core::evaluate(patch, static_cast<double>(i) / cells, static_cast<double>(j) / cells);
        mesh.positions.push_back({static_cast<float>(jet.point[0]),
                                  static_cast<float>(jet.point[1]),
                                  static_cast<float>(jet.point[2])});
      }
    }
    for (std::uint32_t i = 0; i + 1 < corners; ++i) {
      for (std::uint32_t j = 0; j + 1 < corners; ++j) {
        const std::uint32_t a = first + i * corners + j, b = a + corners;
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
      }
    }
  }
  Scene scene;
  scene.materials.resize(1);
  scene.meshes = {std::make_shared<const Mesh>(std::move(mesh))};
  scene.instances = {{0, {}}};
  return scene;
}

// What camera rays hit of the true surface.
std::vector<core::CastHit> true_hits(const core::PreparedScene& scene, const Workload& work,
                                     Isa isa) {
  std::vector<core::CastRay> rays;
  for (const RayBlock& block : work.blocks) {
    for (int i = 0; i < block.count; ++i) {
      rays.push_back({{block.origin[0][i], block.origin[1][i], block.origin[2][i]},
                      {block.direction[0][i], block.direction[1][i], block.direction[2][i]},
                      0,
                      kInfinity});
    }
  }
  std::vector<core::CastHit> hits(rays.size());
  core::CastOptions options;
  options.isa = isa;
  core::cast_rays(scene, rays, options, hits);
  return hits;
}

struct Row {
  const Contender* contender = nullptr;
  std::vector<double> cpu_seconds{};
  double error = 0;         // p99.9 of camera rays, over the diagonal
  std::uint64_t lost = 0;   // camera rays that miss, or are on another sheet
  std::uint64_t extra = 0;  // that hit where nothing is
};

void compare(Row& row, const Workload& work, const std::vector<core::CastHit>& wanted,
             const std::vector<BlockHits>& hits, double diagonal) {
  std::vector<double> errors;
  std::size_t number = 0;
  for (std::size_t b = 0; b < work.blocks.size(); ++b) {
    for (int i = 0; i < work.blocks[b].count; ++i, ++number) {
      const bool is_hit = hits[b].primitive[i] != core::kNoPrimitive;
      if (!wanted[number].is_hit) {
        row.extra += is_hit;
        continue;
      }
      const double off = std::fabs(double{hits[b].t[i]} - double{wanted[number].t}) / diagonal;
      if (!is_hit || off > 0.01) {
        ++row.lost;
      } else {
        errors.push_back(off);
      }
    }
  }
  if (errors.empty()) return;
  const auto at = errors.begin() + static_cast<std::ptrdiff_t>(0.999 * double(errors.size() - 1));
  std::nth_element(errors.begin(), at, errors.end());
  row.error = *at;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

class PatchScene {
 public:
  PatchScene(std::string name, Scene scene, Camera camera, Vec3f light, std::vector<int> cells,
             const CoreSuiteOptions& options)
      : name_(std::move(name)), options_(options), camera_(camera), light_(light) {
    const double start = process_cpu_seconds();
    prepared_ = core::PreparedScene::build(scene, {}).value();
    builds_.push_back({"patches", process_cpu_seconds() - start, 0,
                       1e-6 * static_cast<double>(prepared_->memory_bytes())});
    const core::PreparedScene::Impl& impl = prepared_->impl();
    const Bounds3f box = impl.index.bounds();
    diagonal_ = double{length(box.upper - box.lower)};
    entrants_.push_back(make_ours_patched(impl.index, options.isa));
    for (const int side : cells) {
      const Scene triangles = tessellated(*impl.patches, side);
      std::vector<Bounds3f> boxes;
      const core::TriangleStore store = core::make_triangle_store(triangles, boxes);
      auto embree = make_embree(store, options.isa, {});
      if (!embree) continue;
      for (Contender& contender : embree->contenders)
        contender.name = std::to_string(side) + " x " + std::to_string(side) + " " + contender.name;
      builds_.push_back(embree->builds[0]);
      builds_.back().name = std::to_string(side) + " x " + std::to_string(side) + " embree";
      entrants_.push_back(std::move(embree));
    }
  }

  std::string run() {
    const core::PatchStore& patches = *prepared_->impl().patches;
    std::printf("\n%s, %zu patches, %zu sub-patches\n", name_.c_str(), patches.patches.size(),
                patches.parts.size());
    const Workload primary = primary_rays(camera_, options_.size_px);
    const std::vector<core::CastHit> hits = true_hits(*prepared_, primary, options_.isa);
    const SecondaryRays secondary = secondary_of(primary, hits);
    std::string list = "[" + measure(primary, &hits) + ",";
    list += measure(secondary.shadow, nullptr) + ",";
    list += measure(secondary.bounce, nullptr) + "]";
    std::string builds = "[";
    for (const Build& build : builds_) {
      std::printf("  build %-22s %10.1f ms %14.1f MB\n", build.name.c_str(),
                  1e3 * build.cpu_seconds, build.megabytes);
      JsonObject json;
      json.add("name", build.name).add("cpu_seconds", build.cpu_seconds).add("mb", build.megabytes);
      builds += (builds.size() > 1 ? "," : "") + json.text();
    }
    JsonObject json;
    json.add("scene", name_).add("patches", std::uint64_t{patches.patches.size()});
    json.add("sub_patches", std::uint64_t{patches.parts.size()});
    json.add_raw("rays", list).add_raw("builds", builds + "]");
    return json.text();
  }

 private:
  SecondaryRays secondary_of(const Workload& primary,
                             const std::vector<core::CastHit>& hits) const {
    std::vector<SurfacePlace> places;
    std::size_t number = 0;
    for (const RayBlock& block : primary.blocks) {
      for (int i = 0; i < block.count; ++i, ++number) {
        const core::CastHit& hit = hits[number];
        if (!hit.is_hit) continue;
        const Vec3f d{block.direction[0][i], block.direction[1][i], block.direction[2][i]};
        const Vec3f o{block.origin[0][i], block.origin[1][i], block.origin[2][i]};
        places.push_back({o + d * hit.t, dot(hit.normal, d) > 0 ? -hit.normal : hit.normal,
                          static_cast<std::uint32_t>(number)});
      }
    }
    return secondary_rays(places, 2e-5f * static_cast<float>(diagonal_), light_);
  }

  std::string measure(const Workload& work, const std::vector<core::CastHit>* wanted) const {
    std::vector<Row> rows;
    for (const auto& entrant : entrants_) {
      for (const Contender& contender : entrant->contenders)
        if (contender.kind == work.kind) rows.push_back({&contender});
    }
    std::vector<BlockHits> hits(work.blocks.size());
    for (int repeat = -1; repeat < options_.repeats; ++repeat) {
      for (Row& row : rows) {
        const double start = thread_cpu_seconds();
        for (std::size_t b = 0; b < work.blocks.size(); ++b)
          row.contender->trace(work.blocks[b], hits[b]);
        if (repeat >= 0) row.cpu_seconds.push_back(thread_cpu_seconds() - start);
        if (repeat < 0 && wanted != nullptr) compare(row, work, *wanted, hits, diagonal_);
      }
    }
    return report(work, rows);
  }

  static std::string report(const Workload& work, const std::vector<Row>& rows) {
    const auto rate = [&](const Row& row) {
      return 1e-6 * static_cast<double>(work.ray_count) / median(row.cpu_seconds);
    };
    double best = 0;  // of ours
    for (const Row& row : rows)
      if (row.contender->is_ours) best = std::max(best, rate(row));
    std::printf("  %-32s %12s %12s %12s %8s %8s\n", ray_kind_name(work.kind), "Mrays/CPU-s",
                "ours to it", "error p99.9", "lost", "extra");
    std::string list = "[";
    for (const Row& row : rows) {
      std::printf("  %-32s %12.2f %12.2f %12.2g %8llu %8llu\n", row.contender->name.c_str(),
                  rate(row), best / rate(row), row.error, static_cast<unsigned long long>(row.lost),
                  static_cast<unsigned long long>(row.extra));
      JsonObject json;
      json.add("name", row.contender->name).add("mrays_per_cpu_second", rate(row));
      json.add("ours_to_it", best / rate(row)).add("error", row.error);
      json.add("lost", row.lost).add("extra", row.extra);
      list += (list.size() > 1 ? "," : "") + json.text();
    }
    JsonObject json;
    json.add("kind", std::string(ray_kind_name(work.kind))).add("rays", work.ray_count);
    json.add_raw("rows", list + "]");
    return json.text();
  }

  std::string name_;
  const CoreSuiteOptions& options_;
  Camera camera_;
  Vec3f light_;
  double diagonal_ = 0;
  std::shared_ptr<const core::PreparedScene> prepared_;
  std::vector<std::unique_ptr<Entrants>> entrants_;
  std::vector<Build> builds_;
};

}  // namespace

Status run_patch_suite(const CoreSuiteOptions& options, std::vector<std::string>& json) {
  const Camera camera{{6.5f, -7, 6}, {0.3f, 0, 1.5f}, {0, 0, 1}, 35};
  json.push_back(
      PatchScene("teapot", teapots(1), camera, {8, -3, 9}, {16, 64, 160}, options).run());
  const int side = options.is_quick ? 8 : 16;
  const float wide = 7 * static_cast<float>(side);
  const Camera above{{1.2f * wide, -0.9f * wide, 0.9f * wide},
                     {0.45f * wide, 0.35f * wide, 0.25f * wide},
                     {0, 0, 1},
                     40};
  json.push_back(
      PatchScene("teapots", teapots(side), above, {wide, -wide, 2 * wide}, {4, 8}, options).run());
  return Status::ok();
}

}  // namespace tessera::bench
